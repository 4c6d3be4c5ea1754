"""Stage `detections`: what the networks see in every tour of a scene that an episode of some split has."""

from pathlib import Path

from ovman.perception import detections
from ovman.records.episode import Episode
from ovman.records.visit import VisitManifest
from ovman.workflow.job import job
from ovman.workflow.provenance import digest

with job(snakemake) as work:
    visits = [episode.visits for file in work.inputs("episodes") for episode in Episode.load(file, work.scene)]
    names = sorted({name for pair in visits for name in (pair.first, pair.second)})
    (manifest,) = VisitManifest.read(work.input("visits"))
    detections.run(
        {name: manifest.directory(Path("results/visits"), name) for name in names},
        work.constants,
        [digest(Path(module.__file__)) for module in detections.SIGHT],
        Path("results/journal/detections"),
        work.output("detections"),
    )
