"""Stage `ablation_episodes`: the episodes of a split with some of its settings in force, a file a variant."""

from ovman.evaluation import ablation
from ovman.records.episode import VARIANTS
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    ablation.write_variants(work.input("episodes"), {variant: directory / f"{variant}.jsonl" for variant in VARIANTS})
