"""Stage `detected`: what the encoder learns from, around the masks that the detector finds."""

from training import crops
from ovman.workflow.job import job

with job(snakemake) as work:
    crops.run_detected(work.inputs("pictures"), work.input("weights"), work.constants, work.outputs("crops"))
