"""Perception for agents outside the workflow: its stages on the tours of one run, as they come from the evaluator.

Everything passes through the files that the workflow has of it, so that numbers are rounded as they are there.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ovman.agents.interface import Observation, Visit
from ovman.agents.joint.segments import weigh_tours, write_segments
from ovman.language.vocabulary import all_nouns
from ovman.perception import maps, networks
from ovman.perception.backprojection import Camera
from ovman.perception.clusters import Cluster
from ovman.perception.detections import detect_views
from ovman.perception.networks import detector_of, encoder_of
from ovman.perception.records import Detected, read_detections, read_maps, read_nouns, write_detections, write_maps
from ovman.perception.tour_files import View
from ovman.settings import Arm, Need, Settings

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Content = TypeVar("Content")
KEPT = 8
"""Tours of which the detections are kept: runs under other seeds have the same tours."""
NAME = "tour"


class PerceptionPipeline:
    """The perception of an arm's process, for its contexts (`AgentContext`). Networks are loaded at their first use.

    ValueError, in one line, for an input that the arm does not need.
    """

    def __init__(self, settings: Settings, arm: Arm) -> None:
        """Prepare the pipeline. settings: All of config.yaml."""
        self._settings, self._arm = settings, arm
        self._detected: dict[str, Detected] = {}
        self._maps: dict[str, Sequence[Cluster]] = {}
        self._phrases: dict[str, np.ndarray] = {}

    def mapper(self, visit: Visit) -> Sequence[Cluster]:
        """Return the clusters of the map of a tour."""
        self._check_needs(Need.MAPS)
        seen, content = self._detect(visit), str(visit.content)
        if content not in self._maps:
            found = maps.build_map([seen], self._settings.maps.cluster_radius_m)
            self._maps[content] = _filed(lambda to: write_maps(to, {NAME: found}), read_maps)[NAME]
        return self._maps[content]

    def detections(self, visit: Visit) -> Detected:
        """Return the detections in the frames of a tour."""
        self._check_needs(Need.DETECTIONS)
        return self._detect(visit)

    def made(self, visits: Sequence[Visit], need: Need, read: Callable[[Path], Content]) -> Content:
        """Return the segments of both tours of a run, as `read` reads their file. Only the workflow makes other files."""
        self._check_needs(need)
        if need is not Need.SEGMENTS:
            raise ValueError(f"arms.{self._arm.name}: {need} is not made outside the workflow; run the arm in the workflow")
        first, second = visits
        weighed = weigh_tours(first, second, self._detect(first), self._detect(second), self._settings.joint)
        tours = str(first.content), str(second.content)
        return _filed(lambda to: write_segments(to, {tours: weighed}), read)

    def noun(self, phrase: str) -> np.ndarray:
        """Return the unit embedding (K,) of a noun phrase."""
        self._check_needs(Need.MAPS, Need.DETECTIONS, Need.SEGMENTS, Need.NETWORKS)
        if phrase in all_nouns():
            return self._nouns[phrase]
        if phrase not in self._phrases:
            self._phrases[phrase] = self._networks[1].texts([phrase])[0]
        return self._phrases[phrase]

    def networks(self) -> tuple[Detector, Encoder]:
        """Return the detector and the encoder of section perception. WeightsError if they are not available."""
        self._check_needs(Need.NETWORKS)
        return self._networks

    def _check_needs(self, *needs: Need) -> None:
        if not {*self._arm.needs} & {*needs}:
            raise ValueError(f"arms.{self._arm.name} is given no {needs[0]}; write it under needs, or as --needs {needs[0]}")

    def _detect(self, visit: Visit) -> Detected:
        content = str(visit.content)
        if content not in self._detected:
            if len(self._detected) >= KEPT:
                dropped = next(iter(self._detected))
                del self._detected[dropped]
                self._maps.pop(dropped, None)
            perception = self._settings.perception
            views = [_view(seen) for seen in visit.observations]
            found = detect_views(
                views, *self._networks, perception.detector.min_mask_px, perception.encoder.crop_padding, content
            )
            filed = _filed(lambda to: write_detections(to, {NAME: found}), read_detections)[NAME]
            # Masks are read from the file at their first use, and the file is gone by then.
            self._detected[content] = replace(filed, masks=found.masks)
        return self._detected[content]

    @cached_property
    def _networks(self) -> tuple[Detector, Encoder]:
        return detector_of(self._settings.perception), encoder_of(self._settings.perception)

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


def _view(seen: Observation) -> View:
    assert seen.rgb is not None and seen.depth is not None, "a tour has pictures"
    at = seen.pose
    camera = Camera((at.x, at.y, at.z), at.yaw_deg, at.horizon_deg, seen.field_of_view_deg)
    return View(seen.rgb, seen.depth, camera)
