"""Stage `models`: both networks, their curves and what they were made from, in one folder."""

from ovman.workflow.job import job
from training import models

with job(snakemake) as work:
    names = ("detector_first_curve", "detector_curve", "encoder_true_curve", "encoder_curve")
    curves = [work.input(name) for name in names]
    weights, data = (work.input("detector"), work.input("encoder")), (work.inputs("pictures"), work.inputs("crops"))
    models.run(*weights, curves, *data, work.constants.splits["main"].scenes, work.constants, work.output("models"))
