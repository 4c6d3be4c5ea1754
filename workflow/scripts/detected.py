"""Stage `detected`: what the encoder learns from, around the masks that the detector finds."""

from ovman.workflow.job import job
from training import crops

with job(snakemake) as work:
    crops.run_detected(work.inputs("pictures"), work.input("weights"), work.constants, work.outputs("crops"))
