"""Objects of the maps with their cues of appearance, and what they truly are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman.evaluation.true_grounding import commonest
from ovman.perception.clusters import Cluster
from ovman.perception.cues import Cues, read_cues
from ovman.perception.object_map import ObjectMap
from ovman.perception.records import read_maps

CLIP, HISTOGRAM, EXTENT = CUES = ("clip", "histogram", "extent")
"""Cues of appearance: the features of the crops, hue-saturation histograms, and how far the points reach."""


@dataclass(frozen=True, slots=True, eq=False)
class MapObjects:
    """The N objects of a visit's map. histogram (N, B): mean of the detections' histograms; extent (N, 3): median of their
    extents, metres; instance: what most of the detections that show an instance truly show, None where none does.
    """

    map: ObjectMap
    histogram: np.ndarray
    extent: np.ndarray
    instance: tuple[str | None, ...]

    @staticmethod
    def of(clusters: Sequence[Cluster], cues: Cues) -> MapObjects:
        """From the clusters of a visit and the cues of its detections. ValueError where they are not of the same detections."""
        rows = [cluster.members for cluster in clusters]
        if sum(map(len, rows)) != len(cues):
            raise ValueError(
                f"a map of {sum(map(len, rows))} detections has cues of {len(cues)}; make the stages maps and cues again"
            )
        names = np.array([*cues.instances, ""])[cues.instance]
        return MapObjects(
            ObjectMap.of(clusters),
            np.array([cues.histogram[of].mean(axis=0, dtype=np.float64) for of in rows]).reshape(
                len(rows), cues.histogram.shape[1]
            ),
            np.array([np.median(cues.extent[of].astype(np.float64), axis=0) for of in rows]).reshape(len(rows), 3),
            tuple(commonest(names[of], cues.pixels[of]) for of in rows),
        )


def read_map_objects(maps: Sequence[Path], cues: Sequence[Path]) -> dict[tuple[str, str], MapObjects]:
    """The objects of all maps by (scene, visit). Files are named after their scenes. ValueError for a map without cues."""
    of_scene = {path.stem: path for path in cues}
    found = {}
    for path in maps:
        if path.stem not in of_scene:
            raise ValueError(f"{path.stem}: no cues of its detections; make them first: results/cues/{path.stem}.npz")
        of_visit = read_cues(of_scene[path.stem])
        for visit, clusters in read_maps(path).items():
            found[path.stem, visit] = MapObjects.of(clusters, of_visit[visit])
    return found


def disagreements(first: MapObjects, second: MapObjects, least_extent_m: float) -> Mapping[str, np.ndarray]:
    """How unlike the objects of two maps are by each cue, (N, M) each, at least 0.

    CLIP: one minus the inner product of the features. HISTOGRAM: Hellinger's distance, in [0, 1]. EXTENT: mean of the absolute
    logarithms of the sides' ratios, where a side shorter than least_extent_m counts as that long.
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
