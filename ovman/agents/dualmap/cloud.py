"""Point clouds: thinned to voxels, boxed, and asked what lies near them. World frame, y up, metres."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

UP = 1
"""Index of the vertical coordinate."""
FLOOR = [0, 2]
"""Indices of the coordinates of the floor plane."""


class Cloud:
    """Points (N, 3), N >= 1, that are never changed; their search tree is built when it is first asked for."""

    def __init__(self, points: np.ndarray) -> None:
        self.points = np.ascontiguousarray(points, dtype=np.float64)
        if self.points.ndim != 2 or self.points.shape[1] != 3 or not len(self.points):
            raise ValueError(f"a cloud has points (N, 3), N at least 1, not {self.points.shape}")

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def box(self) -> np.ndarray:
        """(6,): least x, y, z and greatest x, y, z."""
        return np.concatenate([self.points.min(axis=0), self.points.max(axis=0)])

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.points, balanced_tree=False, compact_nodes=False)

    def near(self, points: np.ndarray, radius_m: float) -> np.ndarray:
        """(M,) bool: which of `points` (M, 3) lie within radius_m of a point of the cloud."""
        reach, _ = self._tree.query(points, distance_upper_bound=np.nextafter(radius_m, np.inf))
        return np.isfinite(reach)


def thinned(points: np.ndarray, voxel_m: float) -> np.ndarray:
    """One point a voxel, the mean of those in it: (M, 3) of points (N, 3). The grid is centred on the least corner."""
    cells = np.floor((points - points.min(axis=0)) / voxel_m + 0.5).astype(np.int64)
    spans = cells.max(axis=0) + 1
    flat = (cells[:, 0] * spans[1] + cells[:, 1]) * spans[2] + cells[:, 2]
    order = np.argsort(flat, kind="stable")
    flat = flat[order]
    starts = np.flatnonzero(np.concatenate([[True], flat[1:] != flat[:-1]]))
    counts = np.diff(np.concatenate([starts, [len(flat)]]))
    return np.add.reduceat(points[order], starts, axis=0) / counts[:, None]


def box_iou(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(M, N) volume of the intersection over that of the union of boxes (M, 6) with boxes (N, 6); 0 where neither has any."""
    sides = np.minimum(boxes[:, None, 3:], others[None, :, 3:]) - np.maximum(boxes[:, None, :3], others[None, :, :3])
    shared = np.prod(np.clip(sides, 0.0, None), axis=2)
    union = _volume(boxes)[:, None] + _volume(others)[None, :] - shared
    return np.divide(shared, union, out=np.zeros(shared.shape), where=union > 0)


def _volume(boxes: np.ndarray) -> np.ndarray:
    return np.prod(boxes[:, 3:] - boxes[:, :3], axis=1)


def footprint(box: np.ndarray) -> np.ndarray:
    """(4,): least x, z and greatest x, z of a box (6,)."""
    return box[[0, 2, 3, 5]]


def shared_area(rectangle: np.ndarray, rectangles: np.ndarray) -> np.ndarray:
    """(N,) square metres that a rectangle (4,) on the floor plane shares with rectangles (N, 4)."""
    sides = np.minimum(rectangle[2:], rectangles[:, 2:]) - np.maximum(rectangle[:2], rectangles[:, :2])
    return np.prod(np.clip(sides, 0.0, None), axis=1)


def area(rectangles: np.ndarray) -> np.ndarray:
    """Square metres of rectangles (..., 4) on the floor plane."""
    return np.prod(rectangles[..., 2:] - rectangles[..., :2], axis=-1)
