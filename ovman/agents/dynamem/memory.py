"""DynaMem's memory of features: voxels that hold what was seen there last, and nothing that a later view saw through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ovman.agents.dynamem.looks import Look
from ovman.agents.dynamem.settings import Dynamem

_BITS = 20
"""Of a voxel's number along an axis."""
_APART_M = 1000.0
"""Added to the place of a point for each frame: only points of one frame are neighbours."""


@dataclass(frozen=True, slots=True, eq=False)
class Memory:
    """V voxels in the order of `cell`.

    cell (V,): number of the voxel; point (V, 3): mean of its points, metres; weight (V,): number of its points; seen (V,): number
    of the frame that added to it last; row (V,): where in `rows` (R, K) the mean of their features stands.
    """

    cell: np.ndarray
    point: np.ndarray
    weight: np.ndarray
    seen: np.ndarray
    row: np.ndarray
    rows: np.ndarray = field(repr=False)

    @staticmethod
    def empty() -> Memory:
        """A memory of nothing."""
        none = np.zeros(0, np.int64)
        return Memory(none, np.zeros((0, 3)), np.zeros(0), none, none, np.zeros((0, 0)))

    @property
    def feature(self) -> np.ndarray:
        """(V, K): the mean of the features of each voxel's points."""
        features: np.ndarray = self.rows[self.row]
        return features

    def __len__(self) -> int:
        return len(self.cell)

    def where(self, kept: np.ndarray) -> Memory:
        """The voxels of a mask (V,) bool."""
        if kept.all():
            return self
        # Features are nearly all of a memory, and what goes is mostly little: they are copied once a frame, by `added`.
        return Memory(self.cell[kept], self.point[kept], self.weight[kept], self.seen[kept], self.row[kept], self.rows)


def remembered(frames: Sequence[Look], constants: Dynamem, before: Memory | None = None, first: int = 0) -> Memory:
    """The memory after frames in their order, which number its voxels' `seen` from `first` on.

    before: the memory of `first` frames that came before these, nothing where it is None.
    """
    memory, end = before or Memory.empty(), first + len(frames)
    checked = np.zeros(end, np.int64)
    for number, look in enumerate(frames, first):
        memory = cleared(memory, look, constants)
        # Voxels of another frame are no neighbours, so that only frames that have lost or gained some can have new noise.
        counts = np.bincount(memory.seen, minlength=end)
        memory = without_noise(memory, np.flatnonzero(counts != checked), constants)
        checked = np.bincount(memory.seen, minlength=end)
        memory = added(memory, look, number, constants.voxel_m)
    return memory


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


def without_noise(memory: Memory, frames: Sequence[int] | np.ndarray, constants: Dynamem) -> Memory:
    """The memory without what DBSCAN calls noise in these frames: voxels that are not among enough others of their frame."""
    from scipy.spatial import cKDTree  # loaded where a memory is made: it takes a quarter of a second

    asked = np.flatnonzero(np.isin(memory.seen, frames))
    if not len(asked):
        return memory
    within = np.nextafter(constants.cluster_voxels * constants.voxel_m, np.inf)
    places = np.column_stack([memory.point[asked], memory.seen[asked] * _APART_M])
    core = np.isfinite(cKDTree(places).query(places, [constants.cluster_points], distance_upper_bound=within)[0][:, 0])
    kept = np.ones(len(memory), bool)
    kept[asked] = core
    if core.any() and not core.all():
        distance, _ = cKDTree(places[core]).query(places[~core], distance_upper_bound=within)
        kept[asked[~core]] = np.isfinite(distance)
    return memory.where(kept)


def added(memory: Memory, look: Look, number: int, voxel_m: float) -> Memory:
    """The memory with the points of a frame of that number."""
    if not len(look.points):
        return memory
    cells, which = np.unique(_cells(look.points, voxel_m), return_inverse=True)
    points = np.column_stack([np.bincount(which, along) for along in look.points.T])
    shares = np.bincount(which * len(look.features) + look.of, minlength=len(cells) * len(look.features))
    weight: np.ndarray = np.bincount(which).astype(np.float64)
    features: np.ndarray = shares.reshape(len(cells), len(look.features)) @ look.features
    again = np.isin(memory.cell, cells, assume_unique=True)
    if again.any():
        into = np.searchsorted(cells, memory.cell[again])
        points[into] += memory.point[again] * memory.weight[again, None]
        features[into] += memory.rows[memory.row[again]] * memory.weight[again, None]
        weight[into] += memory.weight[again]
    points, features, seen = points / weight[:, None], features / weight[:, None], np.full(len(cells), number, np.int64)
    if again.all():
        return Memory(cells, points, weight, seen, np.arange(len(cells)), features)
    left = memory.where(~again)
    order = np.argsort(every := np.concatenate([left.cell, cells]))
    return Memory(
        every[order],
        np.concatenate([left.point, points])[order],
        np.concatenate([left.weight, weight])[order],
        np.concatenate([left.seen, seen])[order],
        order,
        np.concatenate([left.feature, features]),
    )


def _cells(points: np.ndarray, voxel_m: float) -> np.ndarray:
    """The numbers (N,) of the voxels of points (N, 3), in the order of x, y, z."""
    x, y, z = (np.floor(points / voxel_m).astype(np.int64) + (1 << (_BITS - 1))).T
    numbers: np.ndarray = (x << (2 * _BITS)) | (y << _BITS) | z
    return numbers
