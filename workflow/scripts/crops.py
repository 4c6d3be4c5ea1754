"""Stage `crops`: what the encoder learns from, around true masks."""

from ovman.workflow.job import job
from training import crops

with job(snakemake) as work:
    crops.run_true(work.input("pictures"), work.constants, work.output("crops"))
