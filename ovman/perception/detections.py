"""Stage `detections`: detections of the recorded tours of a scene."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

from ovman.perception import networks, tour, tour_files
from ovman.perception.detected import Detected
from ovman.perception.records import write_detections
from ovman.perception.store import Store
from ovman.progress import Units
from ovman.settings import Settings

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

SIGHT = (networks, tour, tour_files)
"""The modules that, with their imports, determine what is detected."""


Networks = Callable[[], tuple["Detector", "Encoder"]]
"""Gives the networks, loaded at the first call."""


def networks_of(constants: Settings) -> Networks:
    """The networks of section perception, loaded at the first call of what is returned. It raises WeightsError."""
    perception = constants.perception
    return cache(lambda: (networks.detector_of(perception), networks.encoder_of(perception)))


def looked_at(
    visits: Mapping[str, Path], constants: Settings, code: Sequence[str], kept: Path, loaded: Networks
) -> dict[str, Detected]:
    """The detections of `visits` (name -> directory of its recording), in their order.

    code: digests of the code of SIGHT; kept: directory of a `Store`, which takes new detections. The networks are asked for at
    the first tour that the store does not have. Raises WeightsError, TourError.
    """
    perception, store = constants.perception, Store(kept)
    field_of_view_deg = constants.camera.field_of_view_deg
    seen_by = json.dumps([list(code), networks.looked_at_by(perception)], sort_keys=True)

    def look(directory: Path, content: str) -> Detected:
        return tour.detections(
            list(tour_files.tour(directory, field_of_view_deg)),
            *loaded(),
            perception.detector.min_mask_px,
            perception.encoder.crop_padding,
            content,
        )

    seen: dict[str, Detected] = {}
    units = Units(len(visits))
    for name, directory in visits.items():
        began, content = time.process_time(), tour_files.digest(directory, field_of_view_deg, seen_by)
        seen[name], known = store.kept(content, partial(look, directory, content))
        took = "seen before" if known else f"{time.process_time() - began:.1f} s of the processor"
        units.done(f"{name}: {len(seen[name])} detections, {took}")
    return seen


def run(visits: Mapping[str, Path], constants: Settings, code: Sequence[str], kept: Path, output: Path) -> None:
    """Writes the detections of `visits`. The rest is as for ``looked_at``."""
    write_detections(output, looked_at(visits, constants, code, kept, networks_of(constants)))
