"""Stage `detector`: trains the class-agnostic detector."""

from pathlib import Path

from ovman.job import job
from ovman.training import detector

with job(snakemake) as work:
    folder = Path("results", "training", "detector")
    taught, held_out = work.inputs("taught"), work.inputs("held_out")
    detector.run(taught, held_out, work.constants, folder, work.output("weights"), work.output("curve"))
