"""Stage `predictions`: what a static arm answers to the released episodes."""

from ovman.evaluation import predictions
from ovman.workflow.job import job

with job(snakemake) as work:
    predictions.run(
        work.constants.arm,
        work.input("episodes"),
        work.constants,
        work.output("predictions"),
        next(iter(work.inputs("sightings")), None),
        files={
            name: work.inputs(name)
            for name in ("maps", "maintained", "dualmap", "detections", "segments", "labels", "scenes", "nouns")
        },
    )
