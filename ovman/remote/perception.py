"""Perception for agents outside the workflow: its stages on the tours of one run, as they come from the evaluator.

Everything passes through the files that the workflow has of it, so that numbers are rounded as they are there.
"""

from __future__ import annotations

import tempfile
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ovman.agents.interface import Observation, Visit
from ovman.agents.joint.segments import weigh_tours, write_segments
from ovman.language.vocabulary import all_nouns
from ovman.perception import maps, networks, tour
from ovman.perception.backprojection import Camera
from ovman.perception.clusters import Cluster
from ovman.perception.networks import detector_of, encoder_of
from ovman.perception.records import Detected, read_detections, read_maps, read_nouns, write_detections, write_maps
from ovman.settings import Settings

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Content = TypeVar("Content")
KEPT = 8
"""Tours of which the detections are kept: runs under other seeds have the same tours."""
NAME = "tour"


class PerceptionPipeline:
    """The perception of one process. Networks are loaded at their first use."""

    def __init__(self, settings: Settings) -> None:
        """Prepare the pipeline. settings: All of config.yaml."""
        self._settings = settings
        self._detected: OrderedDict[str, Detected] = OrderedDict()
        self._maps: dict[str, Sequence[Cluster]] = {}
        self._phrases: dict[str, np.ndarray] = {}

    @cached_property
    def networks(self) -> tuple[Detector, Encoder]:
        """The detector and the encoder of section perception. WeightsError if they are not available."""
        return detector_of(self._settings.perception), encoder_of(self._settings.perception)

    def detections(self, visit: Visit) -> Detected:
        """Return the detections in the frames of a tour."""
        content = str(visit.content)
        if content not in self._detected:
            perception = self._settings.perception
            views = [_view(seen) for seen in visit.observations]
            found = tour.detections(
                views, *self.networks, perception.detector.min_mask_px, perception.encoder.crop_padding, content
            )
            filed = _filed(lambda to: write_detections(to, {NAME: found}), read_detections)[NAME]
            # Masks are read from the file at their first use, and the file is gone by then.
            self._detected[content] = replace(filed, packed=found.packed)
        self._detected.move_to_end(content)
        while len(self._detected) > KEPT:
            dropped, _ = self._detected.popitem(last=False)
            self._maps.pop(dropped, None)
        return self._detected[content]

    def map(self, visit: Visit) -> Sequence[Cluster]:
        """Return the clusters of the map of a tour."""
        seen, content = self.detections(visit), str(visit.content)
        if content not in self._maps:
            found = maps.build_map([seen], self._settings.maps.cluster_radius_m)
            self._maps[content] = _filed(lambda to: write_maps(to, {NAME: found}), read_maps)[NAME]
        return self._maps[content]

    def noun(self, phrase: str) -> np.ndarray:
        """Return the unit embedding (K,) of a noun phrase."""
        if phrase in all_nouns():
            return self._nouns[phrase]
        if phrase not in self._phrases:
            self._phrases[phrase] = self.networks[1].texts([phrase])[0]
        return self._phrases[phrase]

    def segments(self, first: Visit, second: Visit, read: Callable[[Path], Content]) -> Content:
        """Return the segments of both tours of a run, as `read` reads their file."""
        weighed = weigh_tours(first, second, self.detections(first), self.detections(second), self._settings.joint)
        tours = str(first.content), str(second.content)
        return _filed(lambda to: write_segments(to, {tours: weighed}), read)

    @cached_property
    def _nouns(self) -> Mapping[str, np.ndarray]:
        """Embeddings of the whole vocabulary, computed together as the stage does."""
        return _filed(lambda to: networks.write_noun_embeddings(all_nouns(), self._settings, to), read_nouns)


def _filed(write: Callable[[Path], Any], read: Callable[[Path], Content]) -> Content:
    """Write a file, and return what is read from it."""
    with tempfile.TemporaryDirectory(prefix="ovman-") as folder:
        file = Path(folder, "content.npz")
        write(file)
        return read(file)


def _view(seen: Observation) -> tour.View:
    assert seen.rgb is not None and seen.depth is not None, "a tour has pictures"
    at = seen.pose
    camera = Camera((at.x, at.y, at.z), at.yaw_deg, at.horizon_deg, seen.field_of_view_deg)
    return tour.View(seen.rgb, seen.depth, camera)
