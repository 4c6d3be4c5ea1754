"""The largest cluster of DBSCAN, for small point clouds."""

from __future__ import annotations

import numpy as np
from numba import njit

_NONE = -1
_SLACK = 1.0 + 1e-9
"""Factor by which cells are larger than the radius, so that rounding never puts neighbours two cells apart."""


def largest_cluster(points: np.ndarray, radius_m: float, least: int) -> np.ndarray:
    """Ascending indices of `points` (N, 3) in the largest cluster of DBSCAN; empty if all points are noise.

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
    """Cluster of each of `points` (N, 3), _NONE for noise; cells (N, 2): its column of space, as wide as the radius."""
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
