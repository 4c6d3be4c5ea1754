"""Point clouds: boxes, neighbours within a radius, thinning, and DBSCAN's largest cluster. World frame, y up, metres.

Kernels are compiled with numba. Their coordinates are columns (3, N) float64.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numba import njit

FLOOR = [0, 2]
"""Indices of the coordinates of the floor plane."""


class Cloud:
    """At least one point, immutable. columns: (3, N) float64, coordinate by coordinate."""

    def __init__(self, columns: np.ndarray) -> None:
        self.columns = columns
        self._chains: tuple[float, np.ndarray, np.ndarray] | None = None

    @staticmethod
    def of(points: np.ndarray) -> Cloud:
        """Return the cloud of points (N, 3). Raises ValueError for another shape or no point."""
        points = np.asarray(points)
        if points.ndim != 2 or points.shape[1] != 3 or not len(points):
            raise ValueError(f"a cloud has points (N, 3), N at least 1, not {points.shape}")
        return Cloud(np.ascontiguousarray(points.T, dtype=np.float64))

    def __len__(self) -> int:
        return len(self.columns[0])

    @cached_property
    def box(self) -> np.ndarray:
        """Least x, y, z and greatest x, y, z (6,)."""
        return np.concatenate([self.columns.min(axis=1), self.columns.max(axis=1)])

    def near(self, asked: np.ndarray, radius_m: float) -> np.ndarray:
        """Return which of the points `asked` (3, M) lie within radius_m of a point of the cloud: (M,) bool."""
        if self._chains is None or self._chains[0] != radius_m:
            self._chains = radius_m, *chain_points(self.columns, 2 * radius_m)
        _, heads, following = self._chains
        return find_near(self.columns, heads, following, 2 * radius_m, asked, radius_m)

    def share_inside(self, box: np.ndarray, margin_m: float) -> float:
        """Return the fraction of the points inside a box (6,) that is enlarged by a margin on every side."""
        low, high = (box[:3] - margin_m)[:, None], (box[3:] + margin_m)[:, None]
        return np.count_nonzero(((self.columns >= low) & (self.columns <= high)).all(axis=0)) / len(self)


def box_iou(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return (M, N) intersection over union of the volumes of boxes (M, 6) and boxes (N, 6); 0 if both volumes are 0."""
    sides = np.minimum(boxes[:, None, 3:], others[None, :, 3:]) - np.maximum(boxes[:, None, :3], others[None, :, :3])
    shared = np.prod(np.clip(sides, 0.0, None), axis=2)
    union = _volume(boxes)[:, None] + _volume(others)[None, :] - shared
    iou: np.ndarray = np.divide(shared, union, out=np.zeros(shared.shape), where=union > 0)
    return iou


def _volume(boxes: np.ndarray) -> np.ndarray:
    volumes: np.ndarray = np.prod(boxes[:, 3:] - boxes[:, :3], axis=1)
    return volumes


# Points hashed by cell --------------------------------------------------------------------------------------------------------

NOTHING = -1


@njit(cache=True)
def chain_points(columns: np.ndarray, cell_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Chain points by hash of their cell: (heads (H,), following (N,)), indices of points; H is a power of two."""
    count = columns.shape[1]
    size = 16
    while size < 2 * count:
        size *= 2
    heads, following = np.full(size, NOTHING, np.int32), np.empty(count, np.int32)
    for k in range(count):
        place = _hash(
            np.int64(np.floor(columns[0, k] / cell_m)),
            np.int64(np.floor(columns[1, k] / cell_m)),
            np.int64(np.floor(columns[2, k] / cell_m)),
            size,
        )
        following[k] = heads[place]
        heads[place] = k
    return heads, following


@njit(cache=True)
def find_near(
    columns: np.ndarray, heads: np.ndarray, following: np.ndarray, cell_m: float, asked: np.ndarray, radius_m: float
) -> np.ndarray:
    """Return which of the points `asked` (3, M) lie within radius_m of one of `columns`, chained by cells of cell_m.

    The cells are twice as wide as the radius, so that along each axis one neighbouring cell is enough.
    """
    found = np.zeros(asked.shape[1], np.bool_)
    least = radius_m * radius_m
    for k in range(asked.shape[1]):
        x, y, z = asked[0, k], asked[1, k], asked[2, k]
        i, j, h = np.int64(np.floor(x / cell_m)), np.int64(np.floor(y / cell_m)), np.int64(np.floor(z / cell_m))
        di = 1 if x - i * cell_m >= radius_m else -1
        dj = 1 if y - j * cell_m >= radius_m else -1
        dh = 1 if z - h * cell_m >= radius_m else -1
        for corner in range(8):
            ci = i + di if corner & 1 else i
            cj = j + dj if corner & 2 else j
            ch = h + dh if corner & 4 else h
            other = heads[_hash(ci, cj, ch, heads.size)]
            while other != NOTHING:
                dx, dy, dz = columns[0, other] - x, columns[1, other] - y, columns[2, other] - z
                if dx * dx + dy * dy + dz * dz <= least:
                    found[k] = True
                    break
                other = following[other]
            if found[k]:
                break
    return found


@njit(cache=True)
def thin(columns: np.ndarray, voxel_m: float) -> np.ndarray:
    """Return the mean point of each voxel (3, M), in the order of the voxels' first points.

    The grid of voxels is centred on the least corner of the points.
    """
    count = columns.shape[1]
    low = np.array([columns[axis].min() for axis in range(3)])
    size = 16
    while size < 2 * count:
        size *= 2
    places = np.full(size, NOTHING, np.int32)
    cells, totals, members = np.empty((3, count), np.int64), np.zeros((3, count)), np.zeros(count)
    voxels = 0
    for k in range(count):
        i = np.int64(np.floor((columns[0, k] - low[0]) / voxel_m + 0.5))
        j = np.int64(np.floor((columns[1, k] - low[1]) / voxel_m + 0.5))
        h = np.int64(np.floor((columns[2, k] - low[2]) / voxel_m + 0.5))
        place = _hash(i, j, h, size)
        while places[place] != NOTHING:
            voxel = places[place]
            if cells[0, voxel] == i and cells[1, voxel] == j and cells[2, voxel] == h:
                break
            place = (place + 1) & (size - 1)
        if places[place] == NOTHING:
            places[place] = voxels
            cells[0, voxels], cells[1, voxels], cells[2, voxels] = i, j, h
            voxels += 1
        voxel = places[place]
        members[voxel] += 1
        for axis in range(3):
            totals[axis, voxel] += columns[axis, k]
    return totals[:, :voxels] / members[:voxels]


@njit(cache=True, inline="always")
def _hash(i: np.int64, j: np.int64, h: np.int64, size: int) -> np.int64:
    """Return a place among `size`, a power of two, for a cell."""
    return ((i * 73856093) ^ (j * 19349663) ^ (h * 83492791)) & (size - 1)


# DBSCAN -----------------------------------------------------------------------------------------------------------------------

_NONE = -1
_SLACK = 1.0 + 1e-9
"""Factor by which cells are larger than the radius, so that rounding never puts neighbours two cells apart."""


def largest_cluster(points: np.ndarray, radius_m: float, least: int) -> np.ndarray:
    """Return the ascending indices of `points` (N, 3) in the largest cluster of DBSCAN; none if all points are noise.

    A point with at least `least` points within radius_m, itself included, is a core point. Another point belongs to the first
    cluster, in the order of the points, that reaches it. Of equally large clusters the first is taken.
    """
    if len(points) < least:
        return np.zeros(0, np.int64)
    points = np.ascontiguousarray(points, np.float64)
    labels = _labels(points, _columns(points, radius_m * _SLACK), radius_m, least)
    if labels.max() == _NONE:
        return np.zeros(0, np.int64)
    return np.flatnonzero(labels == np.argmax(np.bincount(labels[labels >= 0])))


@njit(cache=True)
def _columns(points: np.ndarray, side_m: float) -> np.ndarray:
    """(N, 2) number of each point's column of space, side_m wide, along the two axes in which `points` (N, 3) extend most."""
    low, high = points[0].copy(), points[0].copy()
    for i in range(len(points)):
        for k in range(3):
            low[k], high[k] = min(low[k], points[i, k]), max(high[k], points[i, k])
    least = np.argmin(high - low)
    columns = np.empty((len(points), 2), np.int64)
    for i in range(len(points)):
        for k in range(2):
            axis = k if k < least else k + 1
            columns[i, k] = np.int64((points[i, axis] - low[axis]) / side_m)
    return columns


@njit(cache=True)
def _labels(points: np.ndarray, cells: np.ndarray, radius_m: float, least: int) -> np.ndarray:
    """Return the cluster of each of `points` (N, 3), _NONE for noise.

    cells (N, 2): its column of space, as wide as the radius.
    """
    count, reach = len(points), radius_m * radius_m
    wide, high = cells[:, 0].max() + 1, cells[:, 1].max() + 1
    starts = np.zeros(wide * high + 1, np.int64)
    for i in range(count):
        starts[cells[i, 0] * high + cells[i, 1] + 1] += 1
    for cell in range(wide * high):
        starts[cell + 1] += starts[cell]
    # The points of each cell: first those without a cluster, up to the cell's end.
    ends = starts[:-1].copy()
    inside, place = np.empty(count, np.int64), np.empty(count, np.int64)
    for i in range(count):
        cell = cells[i, 0] * high + cells[i, 1]
        inside[ends[cell]], place[i] = i, ends[cell]
        ends[cell] += 1
    core = np.zeros(count, np.bool_)
    for i in range(count):
        near = 0
        for across in range(max(cells[i, 0] - 1, 0), min(cells[i, 0] + 2, wide)):
            for cell in range(across * high + max(cells[i, 1] - 1, 0), across * high + min(cells[i, 1] + 2, high)):
                k = starts[cell]
                while near < least and k < starts[cell + 1]:
                    near += _square(points, i, inside[k]) <= reach
                    k += 1
        core[i] = near == least
    labels = np.full(count, _NONE, np.int64)
    stack = np.empty(count, np.int64)
    clusters = 0
    for first in range(count):
        if not core[first] or labels[first] != _NONE:
            continue
        labels[first] = clusters
        _take(inside, place, ends, cells[first, 0] * high + cells[first, 1], first)
        stack[0], waiting = first, 1
        while waiting:
            waiting -= 1
            i = stack[waiting]
            for across in range(max(cells[i, 0] - 1, 0), min(cells[i, 0] + 2, wide)):
                for cell in range(across * high + max(cells[i, 1] - 1, 0), across * high + min(cells[i, 1] + 2, high)):
                    k = starts[cell]
                    while k < ends[cell]:
                        j = inside[k]
                        if _square(points, i, j) > reach:
                            k += 1
                            continue
                        labels[j] = clusters
                        _take(inside, place, ends, cell, j)
                        if core[j]:
                            stack[waiting] = j
                            waiting += 1
        clusters += 1
    return labels


@njit(cache=True, inline="always")
def _take(inside: np.ndarray, place: np.ndarray, ends: np.ndarray, cell: int, i: int) -> None:
    """Remove a point from the points of its cell without a cluster."""
    ends[cell] -= 1
    last = inside[ends[cell]]
    inside[place[i]], place[last] = last, place[i]
    inside[ends[cell]], place[i] = i, ends[cell]


@njit(cache=True, inline="always")
def _square(points: np.ndarray, i: int, j: int) -> float:
    x, y, z = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
    square: float = x * x + y * y + z * z
    return square
