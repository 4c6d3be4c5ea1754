"""Stage `predictions`: what a static arm answers to the released episodes."""

from pathlib import Path

from ovman.evaluation import predictions
from ovman.workflow.job import job

with job(snakemake) as work:
    predictions.run(
        work.constants.arm,
        work.input("episodes"),
        work.inputs("trials"),
        work.constants,
        work.output("predictions"),
        Path("results", "visits"),
        {name: work.inputs(name) for name in ("maps", "dualmap", "nouns")},
    )
