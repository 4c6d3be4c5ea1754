"""Stage `split_metrics`: the predictions for a split beside the benchmark's own, judged, and their rates."""

from ovman.analysis import splits
from ovman.workflow.job import job

with job(snakemake) as work:
    splits.run(work.input("episodes"), work.inputs("predictions"), work.constants, work.output("outcomes"), work.output("rates"))
