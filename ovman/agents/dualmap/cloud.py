"""Point clouds with boxes and neighbour queries. World frame, y up, metres."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ovman.agents.dualmap import grid

UP = 1
"""Index of the vertical coordinate."""
FLOOR = [0, 2]
"""Indices of the coordinates of the floor plane."""


class Cloud:
    """At least one point, immutable. columns: (3, N) float64, coordinate by coordinate."""

    def __init__(self, columns: np.ndarray) -> None:
        self.columns = columns
        self._chains: tuple[float, np.ndarray, np.ndarray] | None = None

    @staticmethod
    def of(points: np.ndarray) -> Cloud:
        """The cloud of points (N, 3). ValueError for another shape or no point."""
        points = np.asarray(points)
        if points.ndim != 2 or points.shape[1] != 3 or not len(points):
            raise ValueError(f"a cloud has points (N, 3), N at least 1, not {points.shape}")
        return Cloud(np.ascontiguousarray(points.T, dtype=np.float64))

    def __len__(self) -> int:
        return len(self.columns[0])

    @cached_property
    def box(self) -> np.ndarray:
        """(6,): least x, y, z and greatest x, y, z."""
        return np.concatenate([self.columns.min(axis=1), self.columns.max(axis=1)])

    def near(self, asked: np.ndarray, radius_m: float) -> np.ndarray:
        """(M,) bool: which of the points `asked` (3, M) lie within radius_m of a point of the cloud."""
        if self._chains is None or self._chains[0] != radius_m:
            self._chains = radius_m, *grid.chained(self.columns, 2 * radius_m)
        _, heads, following = self._chains
        return grid.near(self.columns, heads, following, 2 * radius_m, asked, radius_m)

    def inside(self, box: np.ndarray, margin_m: float) -> float:
        """The fraction of the points inside a box (6,) that is enlarged by a margin on every side."""
        low, high = (box[:3] - margin_m)[:, None], (box[3:] + margin_m)[:, None]
        return np.count_nonzero(((self.columns >= low) & (self.columns <= high)).all(axis=0)) / len(self)


def box_iou(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(M, N) volume of the intersection over that of the union of boxes (M, 6) with boxes (N, 6); 0 if both volumes are 0."""
    sides = np.minimum(boxes[:, None, 3:], others[None, :, 3:]) - np.maximum(boxes[:, None, :3], others[None, :, :3])
    shared = np.prod(np.clip(sides, 0.0, None), axis=2)
    union = _volume(boxes)[:, None] + _volume(others)[None, :] - shared
    iou: np.ndarray = np.divide(shared, union, out=np.zeros(shared.shape), where=union > 0)
    return iou


def _volume(boxes: np.ndarray) -> np.ndarray:
    volumes: np.ndarray = np.prod(boxes[:, 3:] - boxes[:, :3], axis=1)
    return volumes


def footprint(box: np.ndarray) -> np.ndarray:
    """(4,): least x, z and greatest x, z of a box (6,)."""
    return box[[0, 2, 3, 5]]


def shared_area(rectangle: np.ndarray, rectangles: np.ndarray) -> np.ndarray:
    """(N,) square metres that a rectangle (4,) on the floor plane shares with rectangles (N, 4)."""
    sides = np.minimum(rectangle[2:], rectangles[:, 2:]) - np.maximum(rectangle[:2], rectangles[:, :2])
    shared: np.ndarray = np.prod(np.clip(sides, 0.0, None), axis=1)
    return shared


def area(rectangles: np.ndarray) -> np.ndarray:
    """Square metres of rectangles (..., 4) on the floor plane."""
    areas: np.ndarray = np.prod(rectangles[..., 2:] - rectangles[..., :2], axis=-1)
    return areas
