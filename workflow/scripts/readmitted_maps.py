"""Stage `readmitted_maps`: maps of the tours of every trial that some setting of the thresholds admits."""

from pathlib import Path

from ovman.models.episode import Episode
from ovman.models.visit_files import VisitManifest
from ovman.perception import detections, readmitted_maps
from ovman.workflow.job import job
from ovman.workflow.provenance import digest

with job(snakemake) as work:
    episodes = Episode.load(work.input("episodes"))
    visits = []
    for file in work.inputs("visits"):
        (manifest,) = VisitManifest.read(file)
        pairs = [episode.visits for episode in episodes if episode.scene == manifest.scene]
        names = sorted({name for pair in pairs for name in (pair.first, pair.second)})
        visits.append({name: manifest.directory(Path("results/visits"), name) for name in names})
    readmitted_maps.run(
        visits,
        work.constants,
        [digest(Path(module.__file__)) for module in detections.SIGHT],
        Path("results/journal/detections"),
        work.outputs("maps"),
    )
