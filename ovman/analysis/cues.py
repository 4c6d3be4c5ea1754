"""Cues of appearance: of the detections of recorded tours, and of the objects of the maps that are made of them.

The cues are CLIP (features of the crops), HISTOGRAM (hue and saturation) and EXTENT (how far the points reach). Each
disagreement of two objects is at least 0. `fit_weights` finds the weights that tell pairs of one instance from pairs of two.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from ovman.analysis.instances import TrueScene, match_masks, read_by_scene, read_scenes, true_ids
from ovman.analysis.statistics import auroc
from ovman.evaluation.true_grounding import commonest
from ovman.perception.backprojection import extents
from ovman.perception.clusters import Cluster, ObjectMap
from ovman.perception.cues import Cues, colour_histograms, read_cues
from ovman.perception.cues import write_cues as write_cue_file
from ovman.perception.records import Detected, read_detections, read_maps
from ovman.perception.tour_files import cameras, view
from ovman.processes import map_items
from ovman.records.visit import Visit, VisitFiles
from ovman.settings import Settings

CLIP, HISTOGRAM, EXTENT = CUES = ("clip", "histogram", "extent")
_Frame = tuple[np.ndarray, np.ndarray, np.ndarray]


def write_cues(
    scene_files: Sequence[Path], detections: Sequence[Path], visits: Path, settings: Settings, directory: Path, workers: int = 1
) -> None:
    """Write the cues of all detections into a directory, one file per scene; scenes without detections have none.

    Settings: appearance.{hue_bins,saturation_bins,extent_share}, camera.field_of_view_deg.
    """
    directory.mkdir(parents=True, exist_ok=True)
    scenes = [scene for scene in read_scenes(scene_files) if scene.name in read_by_scene(detections, read_detections)]
    map_items(partial(_write_cues_of, detections, visits, settings, directory), scenes, workers)


def _write_cues_of(detections: Sequence[Path], visits: Path, settings: Settings, directory: Path, scene: TrueScene) -> None:
    tours: dict[str, Cues] = {}  # a tour that several visits share is looked at once
    frames: dict[str, _Frame] = {}
    of_visit = {}
    for name, detected in read_by_scene(detections, read_detections)[scene.name]().items():
        if detected.content not in tours:
            tours[detected.content] = tour_cues(detected, scene, visits / scene.name / name, settings, frames)
        of_visit[name] = tours[detected.content]
    write_cue_file(directory / f"{scene.name}.npz", of_visit)


def tour_cues(detected: Detected, scene: TrueScene, directory: Path, settings: Settings, frames: dict[str, _Frame]) -> Cues:
    """Compute the cues of the detections of a recorded tour.

    frames: keeps the cues of every frame, by the digest of all that they follow from.
    """
    visit, masks, files = Visit.load(directory), detected.masks(), VisitFiles.load(directory).sha256
    constants, found = settings.appearance, []
    for number, (looked, camera) in enumerate(
        zip(visit.views, cameras(directory, settings.camera.field_of_view_deg), strict=True)
    ):
        rows = np.flatnonzero(detected.view == number)
        pictures = [files.get(f"{number:02d}_{kind}.png", "") for kind in ("rgb", "depth", "ids")]
        given = repr((pictures, camera, looked.instances, detected.confidence[rows].tolist())).encode()
        key = hashlib.sha256(given + np.packbits(masks[rows]).tobytes()).hexdigest()
        if key not in frames:
            frame, ids = view(directory, number, camera), true_ids(scene, visit, directory, number)
            frames[key] = (
                colour_histograms(frame.rgb, masks[rows], constants.hue_bins, constants.saturation_bins),
                extents(frame.depth, masks[rows], camera, constants.extent_share),
                # Every mask counts here, whatever the size of the instance that it shows.
                match_masks(masks[rows], detected.confidence[rows], ids, len(scene.objects), min_mask_px=1).object,
            )
        found.append(frames[key])
    histogram, extent, instance = (np.concatenate(part) for part in zip(*found, strict=True))
    return Cues(
        instances=tuple(o.id for o in scene.objects),
        histogram=histogram,
        extent=extent.astype(np.float32),
        pixels=detected.pixels,
        instance=instance.astype(np.int32),
    )


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
        """Join the clusters of a visit with the cues of its detections.

        Raises:
            ValueError: They are not of the same detections.
        """
        rows = [cluster.members for cluster in clusters]
        if (count := sum(map(len, rows))) != len(cues):
            raise ValueError(f"a map of {count} detections has cues of {len(cues)}; make the stages maps and cues again")
        names = np.array([*cues.instances, ""])[cues.instance]
        histograms = [cues.histogram[of].mean(axis=0, dtype=np.float64) for of in rows]
        medians = [np.median(cues.extent[of].astype(np.float64), axis=0) for of in rows]
        return cls(
            ObjectMap.of(clusters),
            np.array(histograms).reshape(len(rows), cues.histogram.shape[1]),
            np.array(medians).reshape(len(rows), 3),
            tuple(commonest(names[of], cues.pixels[of]) for of in rows),
        )


def read_map_objects(maps: Sequence[Path], cues: Sequence[Path]) -> dict[tuple[str, str], MapObjects]:
    """Read the objects of all maps by (scene, visit), from files named after scenes or directories of them."""
    of_scene, found = read_by_scene(cues, read_cues), {}
    for scene, read in read_by_scene(maps, read_maps).items():
        if scene not in of_scene:
            raise ValueError(f"{scene}: the cues of its detections are missing; make them first: results/cues/")
        of_visit = of_scene[scene]()
        for visit, clusters in read().items():
            found[scene, visit] = MapObjects.of(clusters, of_visit[visit])
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
