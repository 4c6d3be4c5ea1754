"""Stage `readmitted_maps`: maps of the tours of every trial that some setting of the thresholds admits."""

from pathlib import Path

from ovman.perception import detections, readmitted_maps
from ovman.records.episode import Episode
from ovman.records.visit import VisitManifest, VisitPair
from ovman.workflow.job import job
from ovman.workflow.provenance import digest

with job(snakemake) as work:
    pairs: dict[str, list[VisitPair[str]]] = {}
    for episode in Episode.load(work.input("episodes")):
        pairs.setdefault(episode.scene, []).append(episode.visits)
    visits = []
    for file in work.inputs("visits"):
        (manifest,) = VisitManifest.read(file)
        names = sorted({name for pair in pairs.get(manifest.scene, ()) for name in (pair.first, pair.second)})
        visits.append({name: manifest.directory(Path("results/visits"), name) for name in names})
    readmitted_maps.run(
        visits,
        work.constants,
        [digest(Path(module.__file__)) for module in detections.SIGHT],
        Path("results/journal/detections"),
        work.outputs("maps"),
    )
