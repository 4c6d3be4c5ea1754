"""Cues of appearance of the objects of maps.

The cues are CLIP (features of the crops), HISTOGRAM (hue and saturation) and EXTENT (how far the points reach). Each
disagreement of two objects is at least 0. `fit_weights` finds the weights that tell pairs of one instance from pairs of two.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

import cv2
import numpy as np

from ovman.analysis.instances import read_of_scene, read_scenes, scene_files, shown_objects
from ovman.analysis.statistics import auroc
from ovman.evaluation.true_grounding import commonest
from ovman.perception.backprojection import extents
from ovman.perception.clusters import Cluster, ObjectMap
from ovman.perception.records import Detected, read_detections, read_maps
from ovman.perception.tour_files import tour
from ovman.processes import map_items
from ovman.records.scene import Scene
from ovman.records.visit import tour_path
from ovman.settings import Settings

CLIP, HISTOGRAM, EXTENT = CUES = ("clip", "histogram", "extent")
HUES, SATURATIONS = 180, 256
"""Values of the hue and the saturation of a pixel of 8 bit, as OpenCV has them."""


@dataclass(frozen=True, slots=True, eq=False)
class Cues:
    """The N detections of a tour, in their order.

    histogram (N, B): of the mask's hues and saturations, each sums to 1; extent (N, 3): `backprojection.extents`, metres; pixels
    (N,): sizes of the masks; instance (N,): the true instance that the mask shows, "" if it overlaps with no instance enough.
    """

    histogram: np.ndarray
    extent: np.ndarray
    pixels: np.ndarray
    instance: np.ndarray


def tour_cues(detected: Detected, scene: Scene, directory: Path, settings: Settings) -> Cues:
    """Compute the cues of the detections of a recorded tour."""
    masks, constants, found = detected.masks(), settings.appearance, []
    for number, view in enumerate(tour(directory, settings.camera.field_of_view_deg)):
        of_view = masks[detected.view == number]
        histograms = colour_histograms(view.rgb, of_view, constants.hue_bins, constants.saturation_bins)
        found.append((histograms, extents(view.depth, of_view, view.camera, constants.extent_share)))
    histogram, extent = (np.concatenate(part) for part in zip(*found, strict=True))
    # Every mask counts here, whatever the size of the instance that it shows.
    shown = shown_objects(scene, directory, detected, min_mask_px=1)
    names = np.array([*(one.id for one in scene.objects), ""])
    return Cues(histogram, extent.astype(np.float32), detected.pixels, names[shown])


def colour_histograms(rgb: np.ndarray, masks: np.ndarray, hue_bins: int, saturation_bins: int) -> np.ndarray:
    """Return hue-saturation histograms (N, hue_bins * saturation_bins) float32 of masks (N, H, W) of a picture (H, W, 3) uint8.

    Bins have equal width; the saturation's bins of a hue are adjacent. Each histogram sums to 1; that of an empty mask is 0.
    """
    hsv = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2HSV).astype(np.int64)
    cells = hsv[..., 0] * hue_bins // HUES * saturation_bins + hsv[..., 1] * saturation_bins // SATURATIONS
    counts = [np.bincount(cells[mask], minlength=hue_bins * saturation_bins) for mask in masks]
    found = np.array(counts, np.float64).reshape(len(masks), hue_bins * saturation_bins)
    shares: np.ndarray = (found / np.maximum(found.sum(axis=1, keepdims=True), 1)).astype(np.float32)
    return shares


@dataclass(frozen=True, slots=True, eq=False)
class MapObjects:
    """The N objects of a visit's map.

    Attributes:
        histogram: (N, B) mean of the detections' histograms; `extent`: (N, 3) median of their extents, metres.
        instance: The true instance of most of the detections that show one, None without any.
    """

    map: ObjectMap
    histogram: np.ndarray
    extent: np.ndarray
    instance: tuple[str | None, ...]

    @classmethod
    def of(cls, clusters: Sequence[Cluster], cues: Cues) -> MapObjects:
        """Join the clusters of a visit with the cues of its detections."""
        rows = [cluster.members for cluster in clusters]
        histograms = [cues.histogram[of].mean(axis=0, dtype=np.float64) for of in rows]
        medians = [np.median(cues.extent[of].astype(np.float64), axis=0) for of in rows]
        return cls(
            ObjectMap.of(clusters),
            np.array(histograms).reshape(len(rows), cues.histogram.shape[1]),
            np.array(medians).reshape(len(rows), 3),
            tuple(commonest(cues.instance[of], cues.pixels[of]) for of in rows),
        )


MapsOfScenes = Mapping[tuple[str, str], MapObjects]
"""The objects of maps by scene and visit."""


def read_map_objects(
    scenes: Sequence[Path], detections: Sequence[Path], maps: Sequence[Path], visits: Path, settings: Settings, workers: int = 1
) -> MapsOfScenes:
    """Return the objects of all maps. detections, maps: files named after scenes, or directories of them.

    Settings: appearance.{hue_bins,saturation_bins,extent_share}, camera.field_of_view_deg.
    """
    mapped = {file.stem for file in scene_files(maps)}
    every = [scene for scene in read_scenes(scenes) if scene.scene in mapped]
    found = map_items(partial(_read_scene, detections, maps, visits, settings), every, workers)
    return {key: objects for of_scene in found for key, objects in of_scene.items()}


def _read_scene(detections: Sequence[Path], maps: Sequence[Path], visits: Path, settings: Settings, scene: Scene) -> MapsOfScenes:
    tours: dict[str, Cues] = {}  # a tour that several visits share is looked at once
    detected, found = read_of_scene(detections, scene.scene, read_detections), {}
    for visit, clusters in read_of_scene(maps, scene.scene, read_maps).items():
        content = detected[visit].content
        if content not in tours:
            tours[content] = tour_cues(detected[visit], scene, tour_path(visits / scene.scene, visit), settings)
        found[scene.scene, visit] = MapObjects.of(clusters, tours[content])
    return found


def disagreements(first: MapObjects, second: MapObjects, least_extent_m: float) -> dict[str, np.ndarray]:
    """Return the disagreement (N, M) of the objects of two maps by each cue.

    CLIP: one minus the inner product of the features. HISTOGRAM: Hellinger's distance. EXTENT: mean absolute logarithm of the
    ratios of the sides; a side shorter than `least_extent_m` counts as that long.
    """
    n, m = len(first.map), len(second.map)
    if not n or not m:
        return {cue: np.zeros((n, m)) for cue in CUES}
    shared = np.sqrt(first.histogram) @ np.sqrt(second.histogram).T
    sides = [np.log(np.maximum(one.extent, least_extent_m)) for one in (first, second)]
    return {
        CLIP: np.clip(1.0 - first.map.f @ second.map.f.T, 0.0, None),
        HISTOGRAM: np.sqrt(np.clip(1.0 - shared, 0.0, None)),
        EXTENT: np.abs(sides[0][:, None] - sides[1][None]).mean(axis=2),
    }


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """P pairs of map objects of one category, one of each visit: disagreement (P,) by cue, and whether both are one (P,)."""

    unlike: Mapping[str, np.ndarray]
    same: np.ndarray

    @property
    def counts(self) -> tuple[int, int]:
        """The numbers of pairs of one instance and of two."""
        same = int(self.same.sum())
        return same, len(self.same) - same


@dataclass(frozen=True, slots=True)
class Weights:
    """The weights of cues.

    Attributes:
        by_cue: Shares that sum to 1.
        scale: Factors that make the disagreement of each cue as large as the first cue's, on average over the pairs of the fit.
            Shares then leave appearance as heavy against distance as it was.
    """

    by_cue: Mapping[str, float]
    scale: Mapping[str, float]

    @classmethod
    def on(cls, first: str, *others: str) -> Weights:
        """Put all weight on the first of some cues."""
        cues = (first, *others)
        return cls({cue: float(cue == first) for cue in cues}, dict.fromkeys(cues, 1.0))

    def combine(self, unlike: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the weighted sum of disagreements of any shape."""
        total: np.ndarray = np.sum([share * self.scale[cue] * unlike[cue] for cue, share in self.by_cue.items()], axis=0)
        return total


def separation(pairs: Pairs, weights: Weights) -> float:
    """Return the AUROC of the combined cues: the probability that a pair of one instance disagrees less than a pair of two."""
    unlike = -weights.combine(pairs.unlike)
    return auroc(unlike[pairs.same], unlike[~pairs.same])


def fit_weights(pairs: Pairs, cues: Sequence[str], step: float, least_pairs: int, equal_scales: bool = True) -> Weights:
    """Return the weights with the highest AUROC on a grid of shares; of equal ones those with most weight on the first cues.

    All weight is on the first cue if either kind has fewer than `least_pairs` pairs. equal_scales: whether cues are scaled to the
    size of the first.
    """
    if min(pairs.counts) < least_pairs or len(cues) == 1:
        return Weights.on(*cues)
    size = {cue: float(pairs.unlike[cue].mean()) for cue in cues}
    comparable = equal_scales and all(value > 0 for value in size.values())
    scale = {cue: size[cues[0]] / size[cue] if comparable else 1.0 for cue in cues}
    every = [Weights(dict(zip(cues, shares, strict=True)), scale) for shares in share_grid(len(cues), step)]
    return max(every, key=lambda weights: (separation(pairs, weights), *weights.by_cue.values()))


def share_grid(cues: int, step: float) -> list[tuple[float, ...]]:
    """Return all shares of so many cues that sum to 1, in multiples of about `step`, a whole part of 1."""
    parts = math.ceil(1 / step - 1e-9)
    free = product(range(parts + 1), repeat=cues - 1)
    return [(*(k / parts for k in some), (parts - sum(some)) / parts) for some in free if sum(some) <= parts]
