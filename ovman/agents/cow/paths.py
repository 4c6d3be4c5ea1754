"""Shortest paths over the free voxels."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from ovman.agents.cow.voxel_map import Cell, VoxelMap, VoxelState

STRAIGHT, DIAGONAL = 1.0, 1.41
"""Lengths of an edge to one of the eight neighbours, in voxels."""
NOWHERE = -9999
"""scipy's predecessor of an unreachable cell."""


class Paths:
    """The shortest paths from one cell to every other; their lengths equal those of A*.

    Edges join free cells to their eight neighbours. `start` must be covered by the map and counts as free, because the agent
    stands in it.
    """

    def __init__(self, known: VoxelMap, start: Cell) -> None:
        inside = np.array(start) - known.origin
        there = np.concatenate([np.argwhere(known.state), inside[None]])
        low, high = there.min(axis=0), there.max(axis=0) + 1
        self._origin = low + known.origin
        state = known.state[low[0] : high[0], low[1] : high[1]]
        free = (state == VoxelState.FREE) | (state == VoxelState.FRONTIER)
        self._shape = free.shape
        self._start = (int(inside[0] - low[0]), int(inside[1] - low[1]))
        free[self._start] = True
        self._number = np.full(free.shape, -1)
        self._number[free] = np.arange(np.count_nonzero(free))
        self._cells = np.argwhere(free)
        edges = [self._edges(free, *way) for way in ((0, 1), (1, 0), (1, 1), (1, -1))]
        lengths = np.concatenate([np.full(len(e[0]), STRAIGHT if k < 2 else DIAGONAL) for k, e in enumerate(edges)])
        ends = np.concatenate(edges, axis=1)
        count = len(self._cells)
        graph = coo_matrix((lengths, (ends[0], ends[1])), shape=(count, count)).tocsr()
        _, self._before = dijkstra(graph, directed=False, indices=int(self._number[self._start]), return_predecessors=True)

    def to(self, goal: Cell) -> list[Cell] | None:
        """The cells of a shortest path from the start to `goal`, both included; None for an unreachable goal."""
        inside = self._inside(goal)
        number = -1 if inside is None else int(self._number[inside])
        if number < 0:
            return None
        way = [number]
        while (before := int(self._before[way[-1]])) != NOWHERE:
            way.append(before)
        if way[-1] != self._number[self._start]:
            return None
        return [(int(i), int(j)) for i, j in self._cells[way[::-1]] + self._origin]

    def _inside(self, cell: Cell) -> Cell | None:
        i, j = int(cell[0] - self._origin[0]), int(cell[1] - self._origin[1])
        return (i, j) if 0 <= i < self._shape[0] and 0 <= j < self._shape[1] else None

    def _edges(self, free: np.ndarray, down: int, right: int) -> np.ndarray:
        """(2, N) numbers of free cells and of their free neighbours in one direction."""
        height, width = free.shape
        here = np.s_[: height - down, max(-right, 0) : width - max(right, 0)]
        there = np.s_[down:, max(right, 0) : width - max(-right, 0)]
        both = free[here] & free[there]
        return np.stack([self._number[here][both], self._number[there][both]])
