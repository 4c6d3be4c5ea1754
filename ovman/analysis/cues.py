"""Stage `cues`: cues of appearance of the detections of the recorded tours, and what these truly show. Pure."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman.analysis.instances import TrueScene, true_ids
from ovman.analysis.segmentation import segmented
from ovman.perception.backprojection import extents
from ovman.perception.cues import Cues, colours, write_cues
from ovman.perception.detected import Detected
from ovman.perception.records import read_detections
from ovman.perception.tour_files import cameras, view
from ovman.records.visit import Visit, VisitFiles
from ovman.settings import Settings
from ovman.settings.benchmark import Appearance


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    histogram: np.ndarray
    extent: np.ndarray
    instance: np.ndarray


Frames = dict[str, _Frame]
"""What was found in frames, by the digest of all that it follows from."""


def run(scenes: Sequence[Path], detections: Sequence[Path], visits: Path, constants: Settings, outputs: Sequence[Path]) -> None:
    """Writes the cues of all visits of each file of detections, one file for each in their order.

    scenes: records of the stage "scenes", in the same order; visits: directory of the recorded visits of all scenes. constants:
    appearance.*, camera.field_of_view_deg. A tour that several visits share is looked at once, and so is a frame with the same
    detections that several tours share.
    """
    for scene_file, source, output in zip(scenes, detections, outputs, strict=True):
        scene = TrueScene.load(scene_file)
        tours: dict[str, Cues] = {}
        frames: Frames = {}
        made = {}
        for name, seen in read_detections(source).items():
            if seen.content not in tours:
                directory = visits / scene.name / name
                tours[seen.content] = cues_of(
                    seen, scene, directory, constants.camera.field_of_view_deg, constants.appearance, frames
                )
            made[name] = tours[seen.content]
        write_cues(output, made)
        print(f"{scene.name}: {len(made)} visits, {len(tours)} tours, {len(frames)} frames", flush=True)


def cues_of(
    seen: Detected, scene: TrueScene, directory: Path, field_of_view_deg: float, constants: Appearance, frames: Frames
) -> Cues:
    """The cues of the detections of the tour recorded in `directory`. frames: takes what was found, and gives it again.

    TourError for a file of the tour that is missing or damaged.
    """
    visit, masks = Visit.load(directory), seen.masks()
    files = VisitFiles.load(directory).sha256
    found: list[_Frame] = []
    for number, (looked, camera) in enumerate(zip(visit.views, cameras(directory, field_of_view_deg), strict=True)):
        rows = np.flatnonzero(seen.view == number)
        shown = [files.get(f"{number:02d}_{kind}.png", "") for kind in ("rgb", "depth", "ids")]
        what = repr((shown, camera, looked.instances, seen.confidence[rows].tolist())).encode()
        key = hashlib.sha256(what + np.packbits(masks[rows]).tobytes()).hexdigest()
        if key not in frames:
            frame, of_frame = view(directory, number, camera), masks[rows]
            ids = true_ids(scene, visit, directory, number)
            frames[key] = _Frame(
                colours(frame.rgb, of_frame, constants.hue_bins, constants.saturation_bins),
                extents(frame.depth, of_frame, camera, constants.extent_share),
                # Every mask counts here, whatever the size of what it shows.
                segmented(of_frame, seen.confidence[rows], ids, len(scene.objects), min_mask_px=1).object,
            )
        found.append(frames[key])
    return Cues(
        instances=tuple(o.id for o in scene.objects),
        histogram=np.concatenate([one.histogram for one in found]),
        extent=np.concatenate([one.extent for one in found]).astype(np.float32),
        pixels=seen.pixels,
        instance=np.concatenate([one.instance for one in found]).astype(np.int32),
    )
