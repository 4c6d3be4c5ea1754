"""Stage `crops`: what the encoder learns from, around true masks."""

from ovman.job import job
from ovman.training import crops

with job(snakemake) as work:
    crops.run_true(work.input("pictures"), work.constants, work.output("crops"))
