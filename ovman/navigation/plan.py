"""Shortest paths on the grid (A*) and geodesic distances."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from heapq import heappop, heappush

from ovman.navigation.grid import DIRECTIONS, Cell, Grid

Edge = frozenset[Cell]
"""Two neighbouring cells, unordered."""


def shortest_path(
    grid: Grid, start: Cell, goal: Cell, blocked: Collection[Edge] = frozenset(), directions: tuple[Cell, ...] | None = None
) -> tuple[Cell, ...] | None:
    """A shortest path from `start` to `goal`, both included, over edges that are not `blocked`; None if the goal is unreachable.

    A* with the city-block distance. Among paths of equal length the choice depends only on `directions`, the order in which the
    neighbours of a cell are expanded; over free floor such a path turns once. Raises ValueError if an end is not in the grid.
    """
    grid.require(start)
    grid.require(goal)
    directions = DIRECTIONS if directions is None else directions
    goal_i, goal_j = goal
    came_from: dict[Cell, Cell | None] = {start: None}
    length = {start: 0}
    closed: set[Cell] = set()
    # (lower bound of the length through the cell, -length up to it, age): deepest first among equals halves the time.
    open_cells = [(abs(start[0] - goal_i) + abs(start[1] - goal_j), 0, 0, start)]
    age = 0
    while open_cells:
        _, _, _, cell = heappop(open_cells)
        if cell == goal:
            return _trace(came_from, goal)
        if cell in closed:
            continue
        closed.add(cell)
        steps = length[cell] + 1
        for neighbour in grid.neighbours(cell, directions):
            if steps >= length.get(neighbour, steps + 1) or (blocked and frozenset((cell, neighbour)) in blocked):
                continue
            length[neighbour], came_from[neighbour] = steps, cell
            age += 1
            promise = steps + abs(neighbour[0] - goal_i) + abs(neighbour[1] - goal_j)
            heappush(open_cells, (promise, -steps, age, neighbour))
    return None


def geodesic_m(grid: Grid, start: Cell, goal: Cell, blocked: Collection[Edge] = frozenset()) -> float | None:
    """Length in metres of a shortest path; None if the goal is unreachable. ValueError if an end is not in the grid."""
    path = shortest_path(grid, start, goal, blocked)
    return None if path is None else grid.step_m * (len(path) - 1)


def steps_from(grid: Grid, start: Cell) -> dict[Cell, int]:
    """Number of edges of a shortest path from `start` to every cell of its component. Raises ValueError if it is not in the
    grid.
    """
    grid.require(start)
    steps, queue = {start: 0}, deque([start])
    while queue:
        cell = queue.popleft()
        for neighbour in grid.neighbours(cell):
            if neighbour not in steps:
                steps[neighbour] = steps[cell] + 1
                queue.append(neighbour)
    return steps


def _trace(came_from: dict[Cell, Cell | None], goal: Cell) -> tuple[Cell, ...]:
    path: list[Cell] = []
    cell: Cell | None = goal
    while cell is not None:
        path.append(cell)
        cell = came_from[cell]
    return tuple(reversed(path))
