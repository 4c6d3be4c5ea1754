"""The grid of reachable positions: cells of a square lattice on the floor plane, joined to their four neighbours."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass

Cell = tuple[int, int]
"""Lattice indices (i, j), along x and along z."""

DIRECTIONS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""The four neighbours, in the default order of expansion."""

LATTICE_TOLERANCE_M = 1e-3
"""Farthest distance of a position from its lattice point. The error of single precision is far smaller."""

_ORIGIN_DECIMALS = 4
_TIE_DECIMALS = 9
_MAY_WIN = (1.0 + 1e-12, 1e-6)
"""A squared distance, in steps, above the least one by this factor and this sum is above it also when both are rounded."""


@dataclass(frozen=True)
class Grid:
    """Cells with centres at origin + step_m * (i, j); origin is an (x, z) in metres, world frame."""

    step_m: float
    origin: tuple[float, float]
    cells: frozenset[Cell]

    @staticmethod
    def from_positions(points: Iterable[Collection[float]], step_m: float) -> Grid:
        """The grid of `points`, (x, z) or (x, y, z) in metres, which lie on a square lattice of spacing `step_m`.

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
        """(x, z) of a cell's centre, metres. The cell need not be in the grid."""
        return self.origin[0] + self.step_m * cell[0], self.origin[1] + self.step_m * cell[1]

    def cell_at(self, x: float, z: float) -> Cell | None:
        """The cell of the grid whose square contains (x, z), or None; on a border the smaller cell."""
        u, v = self._lattice(x, z)
        cell = (math.ceil(u - 0.5), math.ceil(v - 0.5))
        return cell if cell in self.cells else None

    def neighbours(self, cell: Cell, directions: Iterable[Cell] = DIRECTIONS) -> tuple[Cell, ...]:
        """The neighbours of a cell that are in the grid, in the order of `directions`."""
        i, j = cell
        return tuple(n for di, dj in directions if (n := (i + di, j + dj)) in self.cells)

    def component(self, cell: Cell) -> frozenset[Cell]:
        """The cells that can be reached from `cell`, itself among them. Raises ValueError for a cell that is not in the grid."""
        self.require(cell)
        cells, reached, queue = self.cells, {cell}, [cell]
        for i, j in queue:  # grows meanwhile; the neighbours are written out, as most of the time went into asking for them
            for neighbour in ((i + 1, j), (i, j + 1), (i - 1, j), (i, j - 1)):
                if neighbour in cells and neighbour not in reached:
                    reached.add(neighbour)
                    queue.append(neighbour)
        return frozenset(reached)

    def components(self) -> tuple[frozenset[Cell], ...]:
        """The connected components, largest first, those of equal size by their smallest cells."""
        left, components = set(self.cells), []
        while left:
            component = self.component(next(iter(left)))
            components.append(component)
            left -= component
        return tuple(sorted(components, key=lambda component: (-len(component), min(component))))

    def nearest(self, x: float, z: float, within: Collection[Cell] | None = None) -> Cell:
        """The cell with its centre nearest to (x, z), among `within` (default: the grid); ties go to the smallest (i, j).

        nu(a) of Eq. 4 for `within` the component of the spawn. Raises ValueError for an empty set of cells.
        """
        u, v = self._lattice(x, z)
        among = self.cells if within is None else within
        here = (round(u), round(v))
        if here in among and max(abs(u - here[0]), abs(v - here[1])) < 0.499:
            return here
        if not among:
            raise ValueError(f"no cell to be nearest to ({x:.4f}, {z:.4f}): the set of cells is empty")
        # Rounding is most of the time, so only what may win is rounded.
        away = {(i, j): (i - u) * (i - u) + (j - v) * (j - v) for i, j in among}
        most = min(away.values()) * _MAY_WIN[0] + _MAY_WIN[1]
        return min(
            (cell for cell, square in away.items() if square <= most),
            key=lambda cell: (round((cell[0] - u) ** 2 + (cell[1] - v) ** 2, _TIE_DECIMALS), cell),
        )

    def require(self, cell: Cell) -> None:
        """Raises ValueError for a cell that is not in the grid."""
        if cell not in self.cells:
            raise ValueError(f"cell {cell} at {self.centre(cell)} is not one of the {len(self.cells)} cells of the grid")

    def _lattice(self, x: float, z: float) -> tuple[float, float]:
        return (x - self.origin[0]) / self.step_m, (z - self.origin[1]) / self.step_m


def _offset(coordinate: float, step_m: float) -> float:
    """Offset of a lattice from the world's origin, in (-step/2, step/2], rounded so that single precision does not show."""
    offset = round(coordinate - step_m * round(coordinate / step_m), _ORIGIN_DECIMALS)
    return offset + step_m if offset <= -step_m / 2 else offset
