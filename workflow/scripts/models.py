"""Stage `models`: both networks, their curves and what they were made from, in one folder."""

from training import models
from ovman.workflow.job import job

with job(snakemake) as work:
    names = ("detector", "detector_first_curve", "detector_curve", "encoder", "encoder_true_curve", "encoder_curve")
    names += ("detector_graph", "encoder_graph", "phrases")
    files = {name: work.input(name) for name in names}
    models.run(files, work.inputs("pictures"), work.inputs("crops"), work.constants, work.output("models"))
