"""Point clouds: boxes, neighbours within a radius, thinning, and DBSCAN's largest cluster. World frame, y up, metres."""

from __future__ import annotations

from functools import cached_property
from itertools import product

import numpy as np
from numba import njit
from scipy.spatial import cKDTree


class Cloud:
    """At least one point, immutable. columns: (3, N) float64, coordinate by coordinate."""

    def __init__(self, columns: np.ndarray) -> None:
        self.columns = columns

    @staticmethod
    def of(points: np.ndarray) -> Cloud:
        """Return the cloud of points (N, 3)."""
        return Cloud(np.ascontiguousarray(points.T, dtype=np.float64))

    def __len__(self) -> int:
        return len(self.columns[0])

    @cached_property
    def box(self) -> np.ndarray:
        """Least x, y, z and greatest x, y, z (6,)."""
        return np.concatenate([self.columns.min(axis=1), self.columns.max(axis=1)])

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.columns.T, balanced_tree=False, compact_nodes=False)  # which is made faster

    def near(self, asked: np.ndarray, radius_m: float) -> np.ndarray:
        """Return which of the points `asked` (3, M) lie within radius_m of a point of the cloud: (M,) bool."""
        distance, _ = self._tree.query(asked.T, distance_upper_bound=np.nextafter(radius_m, np.inf))
        near: np.ndarray = np.isfinite(distance)
        return near

    def inside(self, box: np.ndarray, margin_m: float) -> np.ndarray:
        """Return the points (3, M) inside a box (6,) that is enlarged by a margin on every side."""
        low, high = (box[:3] - margin_m)[:, None], (box[3:] + margin_m)[:, None]
        return self.columns[:, ((self.columns >= low) & (self.columns <= high)).all(axis=0)]

    def thin(self, voxel_m: float) -> Cloud:
        """Return the mean point of each voxel, in the order of the voxels' first points.

        The grid of voxels is centred on the least corner of the points.
        """
        import pandas as pd

        cells = np.floor((self.columns - self.box[:3, None]) / voxel_m + 0.5).astype(np.int64)
        voxel, _ = pd.factorize(np.ravel_multi_index(tuple(cells), cells.max(axis=1) + 1))
        return Cloud(np.stack([np.bincount(voxel, along) for along in self.columns]) / np.bincount(voxel))


def box_iou(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return (M, N) intersection over union of the volumes of boxes (M, 6) and boxes (N, 6); 0 if both volumes are 0."""
    sides = np.minimum(boxes[:, None, 3:], others[None, :, 3:]) - np.maximum(boxes[:, None, :3], others[None, :, :3])
    shared = np.prod(np.clip(sides, 0.0, None), axis=2)
    volumes, other_volumes = (np.prod(one[:, 3:] - one[:, :3], axis=1) for one in (boxes, others))
    union = volumes[:, None] + other_volumes[None, :] - shared
    iou: np.ndarray = np.divide(shared, union, out=np.zeros(shared.shape), where=union > 0)
    return iou


# DBSCAN -----------------------------------------------------------------------------------------------------------------------

NOISE = -1


def largest_cluster(points: np.ndarray, radius_m: float, least: int) -> np.ndarray:
    """Return the ascending indices of `points` (N, 3) in the largest cluster of DBSCAN; none if all points are noise.

    A point with at least `least` points within radius_m, itself included, is a core point. Another point belongs to the first
    cluster, in the order of the points, that reaches it. Of equally large clusters the first is taken.
    """
    if len(points) < least:
        return np.zeros(0, np.int64)
    points = np.ascontiguousarray(points, np.float64)
    # Cells are larger than the radius by more than rounding, so that neighbours are never two cells apart.
    cells = np.floor((points - points.min(axis=0)) / (radius_m * (1 + 1e-9))).astype(np.int64) + 1
    sides = cells.max(axis=0) + 2
    numbers = np.ravel_multi_index(tuple(cells.T), sides)
    order = np.argsort(numbers, kind="stable")
    # The three neighbouring cells along z follow each other, so the points near a point are in nine runs of the ordered ones.
    runs = numbers[order, None] + np.array([(i * sides[1] + j) * sides[2] for i, j in product((-1, 0, 1), repeat=2)])
    starts, ends = np.searchsorted(numbers[order], runs - 1), np.searchsorted(numbers[order], runs + 1, "right")
    labels = _label(points[order], starts, ends, np.argsort(order), radius_m * radius_m, least)[np.argsort(order)]
    if labels.max() == NOISE:
        return np.zeros(0, np.int64)
    return np.flatnonzero(labels == np.argmax(np.bincount(labels[labels >= 0])))


@njit(cache=True)
def _label(points: np.ndarray, starts: np.ndarray, ends: np.ndarray, seeds: np.ndarray, reach: float, least: int) -> np.ndarray:
    """Return the cluster of each of `points` (N, 3), NOISE for none.

    starts, ends: (N, 9) the runs of points that may be near; seeds: in which order points begin clusters; reach: squared radius.
    """
    count = len(points)
    core = np.zeros(count, np.bool_)
    for i in range(count):
        near = 0
        for run in range(9):
            for j in range(starts[i, run], ends[i, run]):
                near += _square(points, i, j) <= reach
            if near >= least:
                break
        core[i] = near >= least
    labels, stack, clusters = np.full(count, NOISE), np.empty(count, np.int64), 0
    for seed in seeds:
        if not core[seed] or labels[seed] != NOISE:
            continue
        labels[seed], stack[0], waiting = clusters, seed, 1
        while waiting:
            waiting -= 1
            i = stack[waiting]
            for run in range(9):
                for j in range(starts[i, run], ends[i, run]):
                    if labels[j] == NOISE and _square(points, i, j) <= reach:
                        labels[j] = clusters
                        if core[j]:
                            stack[waiting] = j
                            waiting += 1
        clusters += 1
    return labels


@njit(cache=True, inline="always")
def _square(points: np.ndarray, i: int, j: int) -> float:
    x, y, z = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
    square: float = x * x + y * y + z * z
    return square
