"""The stage "backprojection": the self-check of Eq. backproj over all objects of the scenes, one row a mask."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.instances import TrueScene
from ovman.analysis.localisation import Localised, localised
from ovman.perception.records import read_detections
from ovman.settings import Settings

UNTOUCHED = "untouched"


def run(scenes: Sequence[Path], detections: Sequence[Path], visits: Path, constants: Settings, output: Path) -> None:
    """Writes one row a mask of the untouched tours, true ones and detected ones, scenes in the order given. Lengths in metres.

    scenes: records of the stage "scenes"; detections: files of the stage "detections", named after the scenes (an untouched tour
    that no episode uses was not looked at; its true masks are there all the same); visits: the directory of the recorded
    visits. constants: camera.field_of_view_deg, perception.detector.min_mask_px.
    """
    of_scene = {path.stem: path for path in detections}
    rows: list[Localised] = []
    for path in scenes:
        scene = TrueScene.load(path)
        detected = read_detections(of_scene[scene.name]).get(UNTOUCHED) if scene.name in of_scene else None
        directory, min_mask_px = visits / scene.name / UNTOUCHED, constants.perception.detector.min_mask_px
        rows += localised(scene, directory, constants.camera.field_of_view_deg, min_mask_px, detected)
    frames.write(output, Localised, rows)
    print(f"{len(rows)} masks of {len({(row.scene, row.object) for row in rows})} objects in {len(scenes)} scenes", flush=True)
