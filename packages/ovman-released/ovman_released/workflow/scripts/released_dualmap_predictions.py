"""Stage `released_dualmap_predictions`: what a static arm answers from the maps of DualMap's released code, if there are any."""

from pathlib import Path

from ovman.evaluation import prediction, predictions
from ovman.models.note import Note
from ovman.workflow.job import job

with job(snakemake) as work:
    if Note.read(work.input("note")).ran:
        predictions.run(
            work.constants.arm,
            work.input("episodes"),
            work.inputs("trials"),
            work.constants,
            work.output("predictions"),
            Path("results", "visits"),
            {name: work.inputs(name) for name in ("dualmap", "nouns")},
        )
    else:
        prediction.write(work.output("predictions"), [])
