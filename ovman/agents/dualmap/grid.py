"""Points hashed by the cell of space they lie in: neighbours within a radius, and thinning. Compiled with numba.

All coordinates are columns (3, N) float64, metres.
"""

from __future__ import annotations

import numpy as np
from numba import njit

NOTHING = -1


@njit(cache=True)
def chained(columns: np.ndarray, cell_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Hash chains of points by cell: (heads (H,), following (N,)), indices of points; H is a power of two."""
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
def near(
    columns: np.ndarray, heads: np.ndarray, following: np.ndarray, cell_m: float, asked: np.ndarray, radius_m: float
) -> np.ndarray:
    """(M,) bool: whether each point of `asked` (3, M) lies within radius_m of one of `columns`, chained by cells of cell_m.

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
def thinned(columns: np.ndarray, voxel_m: float) -> np.ndarray:
    """The mean point of each voxel (3, M), in the order of the voxels' first points.

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
    """A place among `size`, a power of two, for a cell."""
    return ((i * 73856093) ^ (j * 19349663) ^ (h * 83492791)) & (size - 1)
