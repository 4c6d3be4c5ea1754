"""Stage `split_metrics`: what arms of one kind did on a split beside the benchmark's own, judged, and its rates."""

from ovman.analysis import splits
from ovman.workflow.job import job

with job(snakemake) as work:
    made = work.output("outcomes"), work.output("rates")
    if work.inputs("scores"):
        splits.run_embodied(work.input("episodes"), work.inputs("scores"), work.constants, *made)
    else:
        splits.run(work.input("episodes"), work.inputs("predictions"), work.constants, *made)
