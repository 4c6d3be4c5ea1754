"""Stage `readmitted_predictions`: what a static arm answers to every trial that some setting of the thresholds admits."""

from ovman.evaluation import predictions
from ovman.workflow.job import job

with job(snakemake) as work:
    perceived = {"maps": work.inputs("maps")[0].parent, "nouns": work.inputs("nouns")[0]}
    predictions.run(work.constants.arm, work.constants, work.input("episodes"), work.output("predictions"), perceived)
