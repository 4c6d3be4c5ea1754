"""DynaMem's memory of features: voxels that hold what was seen there last, and nothing that a later view saw through."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce

import numpy as np

from ovman.agents.dynamem.looks import Look
from ovman.models.settings.baselines import Dynamem

_BITS = 20
"""Of a voxel's number along an axis."""
_APART_M = 1000.0
"""Added to the place of a point for each frame: only points of one frame are neighbours."""


@dataclass(frozen=True, slots=True, eq=False)
class Memory:
    """V voxels in the order of `cell`.

    cell (V,): number of the voxel; point (V, 3): mean of its points, metres; feature (V, K): mean of their features; weight (V,):
    number of its points; seen (V,): number of the frame that added to it last.
    """

    cell: np.ndarray
    point: np.ndarray
    feature: np.ndarray
    weight: np.ndarray
    seen: np.ndarray

    @staticmethod
    def empty() -> Memory:
        """A memory of nothing."""
        return Memory(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 0)), np.zeros(0), np.zeros(0, np.int64))

    def __len__(self) -> int:
        return len(self.cell)

    def where(self, kept: np.ndarray) -> Memory:
        """The voxels of a mask (V,) bool."""
        return Memory(self.cell[kept], self.point[kept], self.feature[kept], self.weight[kept], self.seen[kept])


def remembered(frames: Iterable[Look], constants: Dynamem) -> Memory:
    """The memory after frames in their order, which number its voxels' `seen`."""

    def after(memory: Memory, numbered: tuple[int, Look]) -> Memory:
        number, look = numbered
        return added(without_noise(cleared(memory, look, constants), constants), look, number, constants.voxel_m)

    return reduce(after, enumerate(frames), Memory.empty())


def cleared(memory: Memory, look: Look, constants: Dynamem) -> Memory:
    """The memory without what a frame sees through or sees anew.

    Of the points in the picture up to `farthest_m` away, those go whose pixel shows something farther, and those that a
    detection shows again, which gives them its feature. What is hidden stays, and so does a surface that is seen again, as far
    off as before by at most a voxel's side, where no detection has a feature for it.
    """
    if not len(memory):
        return memory
    rows, columns, away, inside = look.projected(memory.point)
    depth = look.depth[rows, columns]
    judged = inside & (away >= constants.unknown_m) & (away <= constants.farthest_m) & (depth >= constants.unknown_m)
    judged &= depth >= away - constants.hidden_m
    gone = judged & (look.masked[rows, columns] | (depth > away + constants.voxel_m))
    return memory.where(~gone)


def without_noise(memory: Memory, constants: Dynamem) -> Memory:
    """The memory without what DBSCAN calls noise: voxels of a frame that are not among enough others of it."""
    if not len(memory):
        return memory
    from scipy.spatial import cKDTree  # loaded where a memory is made: it takes a quarter of a second

    radius_m, least = constants.cluster_voxels * constants.voxel_m, constants.cluster_points
    places = np.column_stack([memory.point, memory.seen * _APART_M])
    tree = cKDTree(places)
    core = tree.query_ball_point(places, radius_m, return_length=True) >= least
    kept = core.copy()
    if core.any() and not core.all():
        distance, _ = cKDTree(places[core]).query(places[~core], distance_upper_bound=np.nextafter(radius_m, np.inf))
        kept[~core] = np.isfinite(distance)
    return memory.where(kept)


def added(memory: Memory, look: Look, number: int, voxel_m: float) -> Memory:
    """The memory with the points of a frame of that number."""
    if not len(look.points):
        return memory
    cells, which = np.unique(np.concatenate([memory.cell, _cells(look.points, voxel_m)]), return_inverse=True)
    old, new = which[: len(memory)], which[len(memory) :]
    weights = np.concatenate([memory.weight, np.ones(len(new))])
    points = np.concatenate([memory.point, look.points])
    weight = np.bincount(which, weights)
    point = np.column_stack([np.bincount(which, weights * along) for along in points.T]) / weight[:, None]
    counts = np.bincount(new * len(look.features) + look.of, minlength=len(cells) * len(look.features))
    feature = counts.reshape(len(cells), len(look.features)) @ look.features
    if len(memory):
        feature[old] += memory.feature * memory.weight[:, None]
    seen = np.full(len(cells), number)
    seen[old] = memory.seen
    seen[new] = number
    return Memory(cells, point, feature / weight[:, None], weight, seen)


def _cells(points: np.ndarray, voxel_m: float) -> np.ndarray:
    """The numbers (N,) of the voxels of points (N, 3), in the order of x, y, z."""
    x, y, z = (np.floor(points / voxel_m).astype(np.int64) + (1 << (_BITS - 1))).T
    numbers: np.ndarray = (x << (2 * _BITS)) | (y << _BITS) | z
    return numbers
