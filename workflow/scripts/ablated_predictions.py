"""Stage `ablated_predictions`: what a static arm answers to a variant of a split's episodes."""

from pathlib import Path

from ovman.evaluation import predictions
from ovman.workflow.job import job

with job(snakemake) as work:
    predictions.run(
        work.constants.arm,
        work.constants,
        work.input("episodes"),
        work.output("predictions"),
        {"maps": work.inputs("maps")[0].parent, "nouns": work.inputs("nouns")[0]},
        visits=Path("results", "ablation", work.split, "visits"),
    )
