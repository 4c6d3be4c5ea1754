"""From CoW's map to actions: frontiers, shortest paths over the free voxels, and the low-level planner."""

from __future__ import annotations

import heapq
import math

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from ovman.agents.cow import Cow
from ovman.agents.cow.map import EIGHT, Cell, Pose, VoxelMap, VoxelState
from ovman.agents.interface import Action
from ovman.settings.benchmark import Primitives


def find_frontiers(known: VoxelMap, agent: Cell, constants: Cow) -> list[Cell]:
    """Return one target cell per cluster of frontier cells, the nearest to the agent first.

    Frontier cells without a free cell among their eight neighbours do not count; fewer than `frontier_cells` in total give no
    target. Single-linkage clusters at a distance below `cluster_voxels` = 1.5 are the eight-connected components. The target is
    the member nearest to the mean of its cluster.
    """
    state = known.state
    frontier = (state == VoxelState.FRONTIER) & ndimage.binary_dilation(state == VoxelState.FREE, EIGHT)
    if frontier.sum() < constants.frontier_cells:
        return []
    labels, count = ndimage.label(frontier, EIGHT if constants.cluster_voxels > np.sqrt(2.0) else None)
    cells = np.argwhere(frontier)
    label = labels[frontier]
    means: np.ndarray = np.stack([np.bincount(label, cells[:, axis], count + 1)[1:] for axis in (0, 1)], axis=1)
    means /= np.bincount(label, minlength=count + 1)[1:, None]
    off = np.hypot(*(cells - means[label - 1]).T)
    order = np.lexsort((off, label))
    first = order[np.unique(label[order], return_index=True)[1]]
    targets = cells[first] + known.origin
    distance = np.hypot(*(targets - np.array(agent)).T)
    return [(int(i), int(j)) for i, j in targets[np.argsort(distance, kind="stable")]]


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
        """Return the cells of a shortest path from the start to `goal`, both included; None for an unreachable goal."""
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
        """Return the numbers (2, N) of free cells and of their free neighbours in one direction."""
        height, width = free.shape
        here = np.s_[: height - down, max(-right, 0) : width - max(right, 0)]
        there = np.s_[down:, max(right, 0) : width - max(-right, 0)]
        both = free[here] & free[there]
        return np.stack([self._number[here][both], self._number[there][both]])


def turns(by: int) -> tuple[Action, ...]:
    """Return `by` turns to the left, or to the right if it is negative."""
    return (Action.ROTATE_LEFT if by > 0 else Action.ROTATE_RIGHT,) * abs(by)


def headings(count: int) -> tuple[int, ...]:
    """Return the turns to the left for each of `count` headings: 0, 1, -1, ... up to the half turn, which is to the left."""
    return tuple(sorted(range(1 - (count + 1) // 2, count // 2 + 1), key=lambda k: (abs(k), k < 0)))


def steer(
    known: VoxelMap, pose: Pose, goal: Cell, constants: Cow, primitives: Primitives, forbidden: Action | None = None
) -> tuple[Action, ...] | None:
    """Return at least one action that lead to within `waypoint_voxels` of a goal; None if the search fails.

    Best-first search by the distance to the goal over macro-actions, each a turn to one of the headings and a step. At most
    `expansions` nodes are expanded, every cell is entered once, and no occupied one. `forbidden` must not begin the first
    macro-action, because it has just failed.
    """
    scale = 1.0 / constants.voxel_m

    def away(at: Pose) -> float:
        return math.hypot(at.x * scale - goal[0], at.z * scale - goal[1])

    def rounded(at: Pose) -> Cell:
        return round(at.x * scale), round(at.z * scale)

    waiting: list[tuple[float, int, Pose, tuple[Action, ...]]] = [(away(pose), 0, pose, ())]
    entered, made = {rounded(pose)}, 0
    ways = headings(round(360.0 / primitives.turn_deg))
    for _ in range(constants.expansions):
        if not waiting:
            return None
        distance, _, at, actions = heapq.heappop(waiting)
        if actions and distance <= constants.waypoint_voxels:
            return actions
        for by in ways:
            macro = (*turns(by), Action.MOVE_AHEAD)
            if not actions and macro[0] is forbidden:
                continue
            after = at
            for action in macro:
                after = after.after(action, primitives.step_m, primitives.turn_deg)
            cell = rounded(after)
            if cell in entered or known.at(cell) is VoxelState.OCCUPIED:
                continue
            entered.add(cell)
            made += 1
            heapq.heappush(waiting, (away(after), made, after, (*actions, *macro)))
    return None


def face(pose: Pose, target: Cell, constants: Cow, primitives: Primitives) -> tuple[Action, ...]:
    """Return the turns to the heading that is nearest to the direction of a cell."""
    dx, dz = target[0] * constants.voxel_m - pose.x, target[1] * constants.voxel_m - pose.z
    bearing = math.degrees(math.atan2(dx, dz))

    def off(by: int) -> float:
        return abs((bearing - (pose.yaw_deg - by * primitives.turn_deg) + 180.0) % 360.0 - 180.0)

    return turns(min(headings(round(360.0 / primitives.turn_deg)), key=lambda by: (round(off(by), 6), abs(by))))
