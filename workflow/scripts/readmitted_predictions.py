"""Stage `readmitted_predictions`: what a static arm answers to every trial that some setting of the thresholds admits."""

from ovman.evaluation import predictions
from ovman.workflow.job import job

with job(snakemake) as work:
    files = {name: work.inputs(name) for name in ("maps", "nouns")}
    predictions.run(work.constants.arm, work.input("episodes"), work.constants, work.output("predictions"), files=files)
