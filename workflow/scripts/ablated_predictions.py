"""Stage `ablated_predictions`: what a static arm answers to a variant of a split's episodes."""

from pathlib import Path

from ovman.evaluation import predictions
from ovman.workflow.job import job

with job(snakemake) as work:
    predictions.run(
        work.constants.arm,
        work.input("episodes"),
        work.constants,
        work.output("predictions"),
        visits=Path("results", "ablation", work.split, "visits"),
        files={name: work.inputs(name) for name in ("maps", "nouns")},
    )
