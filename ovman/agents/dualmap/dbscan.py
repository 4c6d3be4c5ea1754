"""DBSCAN of small point clouds, of which only the largest cluster is wanted."""

from __future__ import annotations

import numpy as np
from numba import njit

_NONE = -1


def largest_cluster(points: np.ndarray, radius_m: float, least: int) -> np.ndarray:
    """Which of `points` (N, 3) are in the largest cluster of DBSCAN, ascending indices; none where all are noise.

    A point with at least `least` points within radius_m, itself among them, is a core point. A point that is none belongs to the
    first cluster, in the order of the points, that reaches it; of equally large clusters the first is taken.
    """
    if len(points) < least:
        return np.zeros(0, np.int64)
    points = np.ascontiguousarray(points, np.float64)
    axis = int(np.argmax(np.ptp(points, axis=0)))
    order = np.argsort(points[:, axis], kind="stable")
    labels = _labels(points[order], order, axis, radius_m, least)
    if labels.max() == _NONE:
        return np.zeros(0, np.int64)
    return np.flatnonzero(labels == np.argmax(np.bincount(labels[labels >= 0])))


@njit(cache=True)
def _labels(points, order, axis, radius_m, least):
    """Cluster of each point by its index before sorting, _NONE for noise; `points` are sorted along `axis` by `order`."""
    count, reach = len(points), radius_m * radius_m
    core = np.zeros(count, np.bool_)
    first, last = np.empty(count, np.int64), np.empty(count, np.int64)
    low = high = 0
    for i in range(count):
        while points[i, axis] - points[low, axis] > radius_m:
            low += 1
        while high < count and points[high, axis] - points[i, axis] <= radius_m:
            high += 1
        first[i], last[i] = low, high
        near = 0
        for j in range(low, high):
            if _square(points, i, j) <= reach:
                near += 1
                if near == least:
                    core[i] = True
                    break
    place = np.empty(count, np.int64)
    for i in range(count):
        place[order[i]] = i
    labels = np.full(count, _NONE, np.int64)
    stack = np.empty(count, np.int64)
    # The next point along the axis that has no cluster yet, itself if it has none: who has one is passed over at once.
    free = np.arange(count + 1)
    clusters = 0
    for index in range(count):
        start = place[index]
        if not core[start] or labels[index] != _NONE:
            continue
        labels[index] = clusters
        free[start] = start + 1
        stack[0], waiting = start, 1
        while waiting:
            waiting -= 1
            i = stack[waiting]
            j = _next(free, first[i])
            while j < last[i]:
                if _square(points, i, j) <= reach:
                    labels[order[j]] = clusters
                    free[j] = j + 1
                    if core[j]:
                        stack[waiting] = j
                        waiting += 1
                j = _next(free, j + 1)
        clusters += 1
    return labels


@njit(cache=True)
def _next(free, j):
    while free[j] != j:
        free[j] = free[free[j]]
        j = free[j]
    return j


@njit(cache=True, inline="always")
def _square(points, i, j):
    x, y, z = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
    return x * x + y * y + z * z
