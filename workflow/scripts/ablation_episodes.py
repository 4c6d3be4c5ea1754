"""Stage `ablation_episodes`: the episodes of a split with some of its settings in force, a file a variant."""

from ovman.evaluation import ablation
from ovman.workflow.job import job

with job(snakemake) as work:
    ablation.run(work.input("episodes"), {path.stem: path for path in work.outputs("episodes")})
