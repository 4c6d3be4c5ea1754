"""Stage `detector`: trains the class-agnostic detector, from random weights or further from those that it is given."""

from pathlib import Path

from ovman.workflow.job import job
from training import detector

with job(snakemake) as work:
    weights, curve = work.output("weights"), work.output("curve")
    folder = Path("results", "training", snakemake.rule)
    start = next(iter(work.inputs("start")), None)
    detector.run(work.inputs("taught"), work.inputs("held_out"), work.constants, start, folder, weights, curve)
