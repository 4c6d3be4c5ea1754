"""Stage `detections`: detections of the recorded tours of a scene."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path

from ovman.models.settings import Settings
from ovman.perception import networks, tour, tour_files
from ovman.perception.detected import Detected
from ovman.perception.records import write_detections
from ovman.perception.store import Store

SIGHT = (networks, tour, tour_files)
"""The modules that, with their imports, determine what is detected."""


def run(visits: Mapping[str, Path], constants: Settings, code: Sequence[str], kept: Path, output: Path) -> None:
    """Writes the detections of `visits` (name -> directory of its recording), in their order.

    code: digests of the code of SIGHT; kept: directory of a `Store`, which takes new detections. The networks are loaded at
    the first tour that the store does not have. Raises WeightsError, TourError.
    """
    perception, store = constants.perception, Store(kept)
    field_of_view_deg = constants.camera.field_of_view_deg
    seen_by = json.dumps([list(code), networks.looked_at_by(perception)], sort_keys=True)
    loaded = cache(lambda: (networks.detector_of(perception), networks.encoder_of(perception)))

    def look(directory: Path, content: str) -> Detected:
        return tour.detections(
            list(tour_files.tour(directory, field_of_view_deg)),
            *loaded(),
            perception.detector.min_mask_px,
            perception.encoder.crop_padding,
            content,
        )

    seen: dict[str, Detected] = {}
    for name, directory in visits.items():
        began, content = time.process_time(), tour_files.digest(directory, field_of_view_deg, seen_by)
        seen[name], known = store.kept(content, partial(look, directory, content))
        took = "seen before" if known else f"{time.process_time() - began:.1f} s of the processor"
        print(f"{name}: {len(seen[name])} detections, {took}", flush=True)
    write_detections(output, seen)
