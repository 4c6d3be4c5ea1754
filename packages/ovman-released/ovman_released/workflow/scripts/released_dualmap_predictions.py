"""Stage `released_dualmap_predictions`: what a static arm answers from the maps of DualMap's released code, if there are any."""

from ovman.evaluation import predictions
from ovman.records.note import Note
from ovman.workflow.job import job

with job(snakemake) as work:
    if Note.read(work.input("note")).ran:
        predictions.run(
            work.constants.arm,
            work.input("episodes"),
            work.constants,
            work.output("predictions"),
            next(iter(work.inputs("sightings")), None),
            files={name: work.inputs(name) for name in ("dualmap", "nouns")},
        )
    else:
        work.output("predictions").touch()
