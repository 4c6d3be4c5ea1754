"""Stage `ablated_maps`: maps of the tours of all variants of a scene's episodes."""

from pathlib import Path

from ovman.perception import detections, readmitted_maps
from ovman.records.visit import VisitManifest
from ovman.workflow.job import job
from ovman.workflow.provenance import digest

with job(snakemake) as work:
    (manifest,) = VisitManifest.read(work.input("visits"))
    recorded = Path("results", "ablation", work.split, "visits")
    readmitted_maps.run(
        [{name: manifest.directory(recorded, name) for name in manifest.visits}],
        work.constants,
        [digest(Path(module.__file__)) for module in detections.SIGHT],
        Path("results/journal/detections"),
        [work.output("maps")],
    )
