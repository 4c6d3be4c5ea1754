"""Point clouds: boxes, neighbours within a radius, thinning, and DBSCAN's largest cluster. World frame, y up, metres."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
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
        """Return the mean point of each voxel, in the order of the voxels' first points."""
        voxel = _number_voxels(self.columns, voxel_m)
        return Cloud(np.stack([np.bincount(voxel, along) for along in self.columns]) / np.bincount(voxel))


def _number_voxels(columns: np.ndarray, voxel_m: float) -> np.ndarray:
    """Return the number (N,) of the voxel of each point, columns (3, N), in the order of the voxels' first points.

    The grid of voxels is centred on the least corner of the points.
    """
    cells = np.floor((columns - columns.min(axis=1)[:, None]) / voxel_m + 0.5).astype(np.int64)
    voxel, _ = pd.factorize(np.ravel_multi_index(tuple(cells), cells.max(axis=1) + 1))
    return np.asarray(voxel)


def box_iou(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return (M, N) intersection over union of the volumes of boxes (M, 6) and boxes (N, 6); 0 if both volumes are 0."""
    sides = np.minimum(boxes[:, None, 3:], others[None, :, 3:]) - np.maximum(boxes[:, None, :3], others[None, :, :3])
    shared = np.prod(np.clip(sides, 0.0, None), axis=2)
    volumes, other_volumes = (np.prod(one[:, 3:] - one[:, :3], axis=1) for one in (boxes, others))
    union = volumes[:, None] + other_volumes[None, :] - shared
    iou: np.ndarray = np.divide(shared, union, out=np.zeros(shared.shape), where=union > 0)
    return iou


# DBSCAN -----------------------------------------------------------------------------------------------------------------------


CELL = 0.577
"""Side of a cell over the radius: just below 1 / sqrt(3), so that a cell's diagonal is shorter than the radius."""


def largest_cluster(points: np.ndarray, radius_m: float, least: int) -> np.ndarray:
    """Return the ascending indices of `points` (N, 3) in the largest cluster of DBSCAN; none if all points are noise.

    A point with at least `least` points within radius_m, itself included, is a core point. Another point belongs to the first
    cluster, in the order of the points, that reaches it. Of equally large clusters the first is taken.
    """
    count = len(points)
    if count < least:
        return np.zeros(0, np.int64)
    first, second = cKDTree(points).query_pairs(radius_m, output_type="ndarray").T
    core = np.bincount(first, minlength=count) + np.bincount(second, minlength=count) + 1 >= least
    if not core.any():
        return np.zeros(0, np.int64)
    # The points of one cell are neighbours, so a cell stands for its core points: a graph of cells has few nodes and edges.
    cell = _number_voxels(points.T, CELL * radius_m)
    cells, a, b = cell.max() + 1, cell[first], cell[second]
    between = core[first] & core[second] & (a != b)
    edges = np.divmod(pd.unique(a[between] * cells + b[between]), cells)
    _, component = connected_components(coo_array((np.ones(len(edges[0])), edges), (cells, cells)), directed=False)
    _, first_core, cluster = np.unique(component[cell[core]], return_index=True, return_inverse=True)
    labels = np.full(count, count)
    labels[core] = first_core[cluster]  # clusters are numbered by their first core points
    for here, there in ((first, second), (second, first)):
        reached = core[here] & ~core[there]
        np.minimum.at(labels, there[reached], labels[here[reached]])
    sizes = np.bincount(labels[labels < count])
    return np.flatnonzero(labels == np.argmax(sizes))
