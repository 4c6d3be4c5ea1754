"""Stage `predictions`: what a static arm answers to the released episodes."""

from typing import Any

from ovman.agents import predictions
from ovman.job import job

snakemake: Any
with job(snakemake) as work:
    predictions.run(work.arm, work.input("episodes"), work.inputs("trials"), work.constants, work.output("predictions"))
