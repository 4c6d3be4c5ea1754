"""Point clouds: boxes, neighbours within a radius, thinning, and DBSCAN's largest cluster. World frame, y up, metres."""

from __future__ import annotations

import math
from collections.abc import Sequence
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
        return _tree(self.columns.T)

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
APART = 10
"""Distance of two clouds over the radius."""


def find_largest_clusters(clouds: Sequence[np.ndarray], radius_m: float, least: int) -> list[np.ndarray]:
    """Return the ascending indices of the points in DBSCAN's largest cluster of each cloud (N, 3); none if all are noise.

    A point with at least `least` points within radius_m, itself included, is a core point. Another point belongs to the first
    cluster, in the order of the points, that reaches it. Of equally large clusters the first is taken.
    """
    sizes = [len(points) for points in clouds]
    if not sum(sizes):
        return [np.zeros(0, np.int64) for _ in clouds]
    # One search for all clouds, which lie far apart along a fourth axis, is faster than many small ones.
    points = np.column_stack([np.concatenate(clouds), np.repeat(np.arange(len(clouds)) * APART * radius_m, sizes)])
    # The points of one cell are neighbours. So a full cell has core points only, and most pairs of neighbours need no search.
    cell = _number_voxels(points.T, CELL * radius_m)
    core = np.bincount(cell)[cell] >= least
    unsure = np.flatnonzero(~core)
    farthest, _ = _tree(points).query(points[unsure], k=[least], distance_upper_bound=np.nextafter(radius_m, np.inf))
    core[unsure] = np.isfinite(farthest[:, 0])
    inner, rest = np.flatnonzero(core), np.flatnonzero(~core)
    labels = np.full(len(points), len(points))
    labels[inner] = _number_clusters(points[inner], cell[inner], radius_m)
    reached = _tree(points[rest]).sparse_distance_matrix(_tree(points[inner]), radius_m, output_type="ndarray")
    np.minimum.at(labels, rest[reached["i"]], labels[inner[reached["j"]]])
    return [_largest(part, len(points)) for part in np.split(labels, np.cumsum(sizes)[:-1])]


def _largest(labels: np.ndarray, noise: int) -> np.ndarray:
    """Return the indices of the commonest label, the least of equally common ones, leaving `noise` out."""
    found = labels[labels < noise]
    return np.flatnonzero(labels == np.bincount(found).argmax()) if len(found) else np.zeros(0, np.int64)


def _number_clusters(points: np.ndarray, cell: np.ndarray, radius_m: float) -> np.ndarray:
    """Return the numbers (N,) of the clusters of core points (N, 4), in the order of the clusters' first points.

    cell: (N,) of each point. The first point of a cell stands for the others. Only where cells are near each other and not yet
    connected, all of their points are compared.
    """
    _, first, cell = np.unique(cell, return_index=True, return_inverse=True)
    firsts = _tree(points[first])
    count, part = _connect(len(first), firsts.query_pairs(radius_m, output_type="ndarray"))
    if count > 1:
        near = firsts.query_pairs((1 + 2 * math.sqrt(3) * CELL) * radius_m, output_type="ndarray")
        apart = near[part[near[:, 0]] != part[near[:, 1]]]
        compared = np.flatnonzero(np.isin(cell, apart))
        pairs = compared[_tree(points[compared]).query_pairs(radius_m, output_type="ndarray")]
        _, joined = _connect(count, part[cell[pairs]])
        part = joined[part]
    numbers, _ = pd.factorize(part[cell])
    return np.asarray(numbers)


def _connect(count: int, edges: np.ndarray) -> tuple[int, np.ndarray]:
    """Return the number of connected components of a graph with edges (M, 2), and the component (count,) of each node."""
    graph = coo_array((np.ones(len(edges)), edges.T), (count, count))
    components, of_node = connected_components(graph, directed=False)
    return components, of_node


def _tree(points: np.ndarray) -> cKDTree:
    """Return a tree of points (N, D) of the kind that is made faster."""
    return cKDTree(points, balanced_tree=False, compact_nodes=False)
