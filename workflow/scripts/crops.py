"""Stage `crops`: what the encoder learns from, around true masks."""

from training import crops
from ovman.workflow.job import job

with job(snakemake) as work:
    crops.run_true(work.input("pictures"), work.constants, work.output("crops"))
