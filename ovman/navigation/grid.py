"""The grid of reachable positions, shortest paths on it (A*), and waypoints of tours."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from heapq import heappop, heappush

Cell = tuple[int, int]
"""Lattice indices (i, j), along x and along z."""

Edge = frozenset[Cell]
"""Two neighbouring cells, unordered."""

DIRECTIONS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""The four neighbours, in the default order of expansion."""

LATTICE_TOLERANCE_M = 1e-3
"""Farthest distance of a position from its lattice point. The error of single precision is far smaller."""

_ORIGIN_DECIMALS = 4
_TIE_DECIMALS = 9


@dataclass(frozen=True)
class Grid:
    """Cells of a square lattice on the floor plane, joined to their four neighbours.

    Centres are at origin + step_m * (i, j); origin is an (x, z) in metres, world frame.
    """

    step_m: float
    origin: tuple[float, float]
    cells: frozenset[Cell]

    @staticmethod
    def from_positions(points: Iterable[Collection[float]], step_m: float) -> Grid:
        """Build the grid of `points`, (x, z) or (x, y, z) in metres, which lie on a square lattice of spacing `step_m`.

        The origin depends on the lattice alone, so grids of one scene before and after a change share their indices. Raises
        ValueError for a point farther than LATTICE_TOLERANCE_M from the lattice through the smallest point.
        """
        positions = sorted((float(x), float(z)) for x, *_, z in points)
        if not positions:
            return Grid(step_m, (0.0, 0.0), frozenset())
        origin = (_offset(positions[0][0], step_m), _offset(positions[0][1], step_m))
        cells = set()
        for x, z in positions:
            i, j = round((x - origin[0]) / step_m), round((z - origin[1]) / step_m)
            off_x, off_z = x - origin[0] - i * step_m, z - origin[1] - j * step_m
            if max(abs(off_x), abs(off_z)) > LATTICE_TOLERANCE_M:
                raise ValueError(
                    f"position ({x:.4f}, {z:.4f}) is ({off_x:+.4f}, {off_z:+.4f}) m off the lattice of {step_m} m through "
                    f"({positions[0][0]:.4f}, {positions[0][1]:.4f}); are the positions of another grid size?"
                )
            cells.add((i, j))
        return Grid(step_m, origin, frozenset(cells))

    def centre(self, cell: Cell) -> tuple[float, float]:
        """Return (x, z) of a cell's centre, metres. The cell need not be in the grid."""
        return self.origin[0] + self.step_m * cell[0], self.origin[1] + self.step_m * cell[1]

    def cell_at(self, x: float, z: float) -> Cell | None:
        """Return the cell of the grid whose square contains (x, z), or None; on a border the smaller cell."""
        u, v = self._lattice(x, z)
        cell = (math.ceil(u - 0.5), math.ceil(v - 0.5))
        return cell if cell in self.cells else None

    def neighbours(self, cell: Cell, directions: Iterable[Cell] = DIRECTIONS) -> tuple[Cell, ...]:
        """Return the neighbours of a cell that are in the grid, in the order of `directions`."""
        i, j = cell
        return tuple(n for di, dj in directions if (n := (i + di, j + dj)) in self.cells)

    def component(self, cell: Cell) -> frozenset[Cell]:
        """Return the cells that can be reached from `cell`, including it. ValueError for a cell outside the grid."""
        return frozenset(steps_from(self, cell))

    def components(self) -> tuple[frozenset[Cell], ...]:
        """Return the connected components, largest first, those of equal size by their smallest cells."""
        left, components = set(self.cells), []
        while left:
            component = self.component(next(iter(left)))
            components.append(component)
            left -= component
        return tuple(sorted(components, key=lambda component: (-len(component), min(component))))

    def nearest(self, x: float, z: float, within: Collection[Cell] | None = None) -> Cell:
        """Return the cell with its centre nearest to (x, z), among `within` or the whole grid; ties go to the smallest (i, j).

        With `within` the component of the spawn this is nu(a) of Eq. 4. ValueError for an empty set of cells.
        """
        u, v = self._lattice(x, z)
        among = self.cells if within is None else within
        here = (round(u), round(v))
        if here in among and max(abs(u - here[0]), abs(v - here[1])) < 0.499:
            return here
        if not among:
            raise ValueError(f"no cell to be nearest to ({x:.4f}, {z:.4f}): the set of cells is empty")
        return min(among, key=lambda cell: (round((cell[0] - u) ** 2 + (cell[1] - v) ** 2, _TIE_DECIMALS), cell))

    def require(self, cell: Cell) -> None:
        """Raise ValueError for a cell outside the grid."""
        if cell not in self.cells:
            raise ValueError(f"cell {cell} at {self.centre(cell)} is not one of the {len(self.cells)} cells of the grid")

    def _lattice(self, x: float, z: float) -> tuple[float, float]:
        return (x - self.origin[0]) / self.step_m, (z - self.origin[1]) / self.step_m


def _offset(coordinate: float, step_m: float) -> float:
    """Return the offset of a lattice from the world's origin, in (-step/2, step/2], free of single precision's noise."""
    offset = round(coordinate - step_m * round(coordinate / step_m), _ORIGIN_DECIMALS)
    return offset + step_m if offset <= -step_m / 2 else offset


def shortest_path(
    grid: Grid, start: Cell, goal: Cell, blocked: Collection[Edge] = frozenset(), directions: tuple[Cell, ...] | None = None
) -> tuple[Cell, ...] | None:
    """Return a shortest path from `start` to `goal`, both included, over edges that are not `blocked`, or None.

    A* with the city-block distance. Among paths of equal length the choice depends only on `directions`, the order in which the
    neighbours of a cell are expanded; over free floor such a path turns once. ValueError if an end is outside the grid.
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
            path = [goal]
            while (before := came_from[path[-1]]) is not None:
                path.append(before)
            return tuple(reversed(path))
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
    """Return the length of a shortest path in metres, or None if the goal is unreachable."""
    path = shortest_path(grid, start, goal, blocked)
    return None if path is None else grid.step_m * (len(path) - 1)


def steps_from(grid: Grid, start: Cell, blocked: Collection[Edge] = frozenset()) -> dict[Cell, int]:
    """Return the number of edges of a shortest path over edges that are not `blocked` from `start` to every cell that has one."""
    grid.require(start)
    steps, queue = {start: 0}, deque([start])
    while queue:
        cell = queue.popleft()
        for neighbour in grid.neighbours(cell):
            if neighbour not in steps and not (blocked and frozenset((cell, neighbour)) in blocked):
                steps[neighbour] = steps[cell] + 1
                queue.append(neighbour)
    return steps


def farthest_points(grid: Grid, component: Collection[Cell], count: int, first: Cell) -> tuple[Cell, ...]:
    """Return `count` cells of a component by farthest-point sampling over geodesic distance, beginning with `first`.

    Ties go to the smallest (i, j).

    Raises:
        ValueError: `first` is not in the component, the component has fewer cells, or a cell cannot be reached from `first`.
    """
    candidates = sorted(component)
    if first not in component:
        raise ValueError(f"the first waypoint {first} is not in the component")
    if not 1 <= count <= len(candidates):
        raise ValueError(f"a component of {len(candidates)} cells does not have {count} waypoints")
    distance = steps_from(grid, first)
    unreachable = next((cell for cell in candidates if cell not in distance), None)
    if unreachable is not None:
        raise ValueError(f"cell {unreachable} cannot be reached from the first waypoint {first}")
    chosen = [first]
    while len(chosen) < count:
        farthest = min(candidates, key=lambda cell: (-distance[cell], cell))
        chosen.append(farthest)
        from_farthest = steps_from(grid, farthest)
        distance = {cell: min(distance[cell], from_farthest[cell]) for cell in candidates}
    return tuple(chosen)
