"""Stage `metrics`: one row an (episode, arm, seed), and rates."""

from ovman.analysis import metrics
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    metrics.write_metrics(work.input("episodes"), work.inputs("predictions"), work.inputs("scores"), work.constants, directory)
