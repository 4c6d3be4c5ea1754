"""Stage `predictions`: what a static arm answers to the released episodes."""

from ovman.agents import predictions
from ovman.job import job

with job(snakemake) as work:
    predictions.run(
        work.arm,
        work.input("episodes"),
        work.inputs("trials"),
        work.constants,
        work.output("predictions"),
        work.inputs("maps"),
        next(iter(work.inputs("nouns")), None),
    )
