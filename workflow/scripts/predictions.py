"""Stage `predictions`: what a static arm answers to the released episodes."""

from ovman.evaluation import predictions
from ovman.workflow.job import job

DIRECTORIES = ("maps", "maintained", "dualmap", "detections", "segments", "labels")

with job(snakemake) as work:
    perceived = {name: files[0].parent for name in DIRECTORIES if (files := work.inputs(name))}
    predictions.run(
        work.constants.arm,
        work.constants,
        work.input("episodes"),
        work.output("predictions"),
        perceived | ({"nouns": work.input("nouns")} if work.inputs("nouns") else {}),
        next(iter(work.inputs("sightings")), None),
        work.inputs("scenes"),
    )
