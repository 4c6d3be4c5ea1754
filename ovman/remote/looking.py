"""What an arm of ours perceives where it has only what comes over the line: the workflow's own stages, on the tours of one run.

Everything passes through the files that the workflow has of it, so that numbers are rounded as they are there.
"""

from __future__ import annotations

import tempfile
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ovman.agents.interface import Visit
from ovman.agents.joint.segments import weigh_tours, write_segments
from ovman.language.vocabulary import all_nouns
from ovman.perception import maps, nouns, tour
from ovman.perception.backprojection import Camera
from ovman.perception.clusters import Cluster
from ovman.perception.detected import Detected
from ovman.perception.networks import detector_of, encoder_of
from ovman.perception.records import read_detections, read_maps, read_nouns, write_detections, write_maps
from ovman.settings import Settings

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Made = TypeVar("Made")
KEPT = 8
"""Tours of which the detections are kept: runs under other seeds have the same."""
NAME = "tour"


class Looking:
    """Perception of one process. settings: of config.yaml, all of them. Networks are loaded at their first use."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._detected: OrderedDict[str, Detected] = OrderedDict()
        self._maps: dict[str, Sequence[Cluster]] = {}
        self._phrases: dict[str, np.ndarray] = {}

    @cached_property
    def networks(self) -> tuple[Detector, Encoder]:
        """The detector and the encoder of section perception. WeightsError if they are not available."""
        return detector_of(self._settings.perception), encoder_of(self._settings.perception)

    def detections(self, visit: Visit) -> Detected:
        """The detections in the frames of a tour."""
        content = str(visit.content)
        if content not in self._detected:
            perception = self._settings.perception
            views = [_view(seen) for seen in visit.observations]
            found = tour.detections(
                views, *self.networks, perception.detector.min_mask_px, perception.encoder.crop_padding, content
            )
            self._detected[content] = self._filed(content, lambda to: write_detections(to, {NAME: found}), read_detections)[NAME]
        self._detected.move_to_end(content)
        while len(self._detected) > KEPT:
            dropped, _ = self._detected.popitem(last=False)
            self._maps.pop(dropped, None)
        return self._detected[content]

    def map(self, visit: Visit) -> Sequence[Cluster]:
        """The clusters of the map of a tour."""
        seen, content = self.detections(visit), str(visit.content)
        if content not in self._maps:
            found = maps.mapped([seen], self._settings.maps.cluster_radius_m)
            self._maps[content] = self._filed("map", lambda to: write_maps(to, {NAME: found}), read_maps)[NAME]
        return self._maps[content]

    def noun(self, phrase: str) -> np.ndarray:
        """Unit embedding (K,) of a noun phrase."""
        if phrase in all_nouns():
            return self._nouns[phrase]
        if phrase not in self._phrases:
            self._phrases[phrase] = self.networks[1].texts([phrase])[0]
        return self._phrases[phrase]

    def segments(self, first: Visit, second: Visit, read: Callable[[Path], Made]) -> Made:
        """The segments of both tours of a run."""
        weighed = weigh_tours(first, second, self.detections(first), self.detections(second), self._settings.joint)
        tours = str(first.content), str(second.content)
        return self._filed("segments", lambda to: write_segments(to, {tours: weighed}), read)

    @cached_property
    def _nouns(self) -> Mapping[str, np.ndarray]:
        """Of the whole vocabulary at once, as the stage has it."""
        return self._filed("nouns", lambda to: nouns.run(all_nouns(), self._settings, to), read_nouns)

    def _filed(self, name: str, write: Callable[[Path], Any], read: Callable[[Path], Made]) -> Made:
        with tempfile.TemporaryDirectory(prefix="ovman-") as folder:
            file = Path(folder, f"{name}.npz")
            write(file)
            return read(file)


def _view(seen: Any) -> tour.View:
    at = seen.pose
    camera = Camera((at.x, at.y, at.z), at.yaw_deg, at.horizon_deg, seen.field_of_view_deg)
    return tour.View(seen.rgb, seen.depth, camera)
