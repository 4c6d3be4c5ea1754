"""Waypoints of a tour: farthest-point sampling over geodesic distance."""

from __future__ import annotations

from collections.abc import Collection

from ovman.navigation.grid import Cell, Grid
from ovman.navigation.plan import steps_from


def farthest_points(grid: Grid, component: Collection[Cell], count: int, first: Cell) -> tuple[Cell, ...]:
    """`count` cells of a component: `first`, then each time the cell whose geodesic distance to the nearest one chosen is
    largest.

    Ties go to the smallest (i, j). Distances are geodesic in the grid. Raises ValueError where `first` is not in `component`, the
    component has fewer than `count` cells, or some cell of it cannot be reached from `first`.
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
