"""Stage `controls`: of all splits, who reaches what, controls next to agents, arm against arm, and success by coverage."""

from ovman.analysis.splits import write_across_splits
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    folders = {path.parent.name: path.parent for path in work.inputs("metrics")}
    write_across_splits(folders, work.constants, directory)
