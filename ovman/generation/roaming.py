"""Where a mover can go from where it stands: free floor on a lattice. Pure geometry on the record of a scene.

The simulator teleports a mover and does not stop it at obstacles. So its floor is only what the record of the scene shows
to be free: places with room for the agent's body, and the place of the instance itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from ovman.generation.placement import CLEARANCE_M, FreeFloor
from ovman.navigation.grid import Grid
from ovman.records.geometry import Point
from ovman.records.scene import Cell, Roam, Scene, SceneObject
from ovman.sim.world import AGENT_RADIUS_M, WAYS

ON_FLOOR_M = 0.05
"""What ends this much above the floor stands on something else."""
SAMPLING_M = 0.15
"""Largest distance between the points of a box that are looked up on the floor; a disc of the agent's radius bridges it."""
GROWS_M = 1e-6
"""Smaller differences of distances are none."""


def roam(scene: Scene, item: SceneObject, floor: FreeFloor, step_m: float) -> Roam | None:
    """Return the floor that `item` can roam in steps of `step_m` from where it stands, or None if it cannot move from there.

    An instance that carries something, or that stands on something, cannot move: it would drop its load, or fall. An instance
    closer to others than a free place allows (a chair under a table) is first pulled straight out: no near box comes nearer,
    overlapping boxes separate, and the way is at most as long as the instance.
    """
    if item.bottom_y > scene.floor_y + ON_FLOOR_M or carries(scene, item):
        return None
    here = np.array(item.place)
    low, high = np.floor((floor.cells.min(axis=0) - here) / step_m), np.ceil((floor.cells.max(axis=0) - here) / step_m)
    columns, rows = (np.arange(min(a, 0), max(b, 0) + 1).astype(int) for a, b in zip(low, high, strict=True))
    cells = np.array([(column, row) for row in rows for column in columns])
    apart = floor.apart(here + step_m * cells)
    clear = np.all(apart > CLEARANCE_M, axis=1)
    # Where it stands there is floor, whatever else is there.
    inside = _inside(floor, here, here + step_m * cells)
    known = {(int(column), int(row)): k for k, (column, row) in enumerate(cells) if inside[k] or not (column or row)}
    free: set[Cell] = {cell for cell, k in known.items() if clear[k]} | {(0, 0)}
    for step in WAYS.values():
        own_m = 2 * float(np.abs(step) @ floor.half) + CLEARANCE_M
        free |= set(_way_out(step, int(np.ceil(own_m / step_m)), known, clear, apart))
    return _over_connected(*item.place, step_m, free)


def side(floor: Roam, other: Point, clear_m: float) -> Roam | None:
    """Return a mover's floor on its own side of the line half-way to `other`, at least `clear_m` from it; None if it cannot move.

    Another mover stands at `other`. Movers that are no wider than `clear_m` never meet.
    """
    here, there = np.array([floor.x, floor.z]), np.array(other)
    length = float(np.hypot(*(there - here)))
    if length < 2 * clear_m:
        return None
    along = (there - here) / length
    kept = {cell for cell in floor.cells if float((np.array(floor.at(cell)) - here) @ along) <= length / 2 - clear_m}
    return _over_connected(floor.x, floor.z, floor.step_m, kept)


def cut(floor: Roam, points: Sequence[Point], away_m: float) -> Roam | None:
    """Return a mover's floor at least `away_m` from each of `points`, metres; None if it cannot move there from its start."""
    cells = sorted(floor.cells)
    places = np.array([floor.x, floor.z]) + floor.step_m * np.array(cells)
    away = np.hypot(*(places[:, None] - np.array(points).reshape(-1, 2)).transpose(2, 0, 1)) >= away_m
    kept = {cell for cell, free in zip(cells, away.all(axis=1), strict=True) if free}
    return _over_connected(floor.x, floor.z, floor.step_m, kept) if (0, 0) in kept else None


def carries(scene: Scene, item: SceneObject) -> bool:
    """Return whether something stands on `item`, or in it, and on nothing else."""
    floors = {o.id for o in scene.objects if o.category == "Floor"}
    return any(
        item.id in o.parents and set(o.parents) - floors == {item.id} and o.bottom_y > scene.floor_y + ON_FLOOR_M
        for o in scene.objects
    )


def _inside(floor: FreeFloor, here: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return (M,) whether the object's box at each of `points` is over known floor and off the waypoints.

    Known floor lies within the agent's radius of a cell that it can reach, where the object stands (`here`), and between the two,
    since the object's own body keeps the agent away. In a home all floor is known.
    """
    inside = floor.off_waypoints(points)
    across = [np.linspace(-h, h, int(np.ceil(2 * h / SAMPLING_M)) + 1) for h in floor.half]
    body = np.array([(x, z) for x in across[0] for z in across[1]])
    tree = KDTree(floor.cells)
    from_body = np.hypot(*np.maximum(np.abs(floor.cells - here) - floor.half, 0.0).T)
    beside = floor.cells[from_body <= AGENT_RADIUS_M + floor.step_m]
    chosen = np.flatnonzero(inside)
    samples = (points[chosen][:, None] + body).reshape(-1, 2)
    if floor.is_whole:
        on_floor = np.ones(len(samples), bool)
    else:
        on_floor = tree.query(samples, distance_upper_bound=AGENT_RADIUS_M + GROWS_M)[0] <= AGENT_RADIUS_M
        unsure = np.flatnonzero(~on_floor)
        on_floor[unsure] = _between(samples[unsure], here, floor.half, beside)
    # It may stand against a wall.
    in_room = floor.find_rooms(points[chosen][:, None] + body * (1 - CLEARANCE_M / floor.half)) == floor.find_rooms(here)
    inside[chosen] = (on_floor.reshape(len(chosen), len(body)) & in_room).all(axis=1)
    return inside


def _between(points: np.ndarray, centre: np.ndarray, half: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return (M,) whether each of `points` (M, 2) lies in the convex hull of the box and one of `ends` (K, 2).

    Some t of [0, 1] has the point in the box that is shrunk by 1 - t towards the end: four inequalities linear in t.
    """
    found = np.zeros(len(points), bool)
    for end in ends:
        least, most = np.zeros(len(points)), np.ones(len(points))
        for axis in (0, 1):
            for side in (1, -1):
                slope = half[axis] - side * (end[axis] - centre[axis])
                room = half[axis] - side * (points[:, axis] - centre[axis]) + GROWS_M
                if slope > 0:
                    most = np.minimum(most, room / slope)
                elif slope < 0:
                    least = np.maximum(least, room / slope)
                else:
                    most = np.where(room < 0, -1.0, most)
        found |= least <= most
    return found


def _way_out(step: Cell, most: int, known: dict[Cell, int], clear: np.ndarray, apart: np.ndarray) -> list[Cell]:
    """Return the cells straight along `step` until the object stands clear, at most `most` steps away; none if it never does."""
    passed = [(0, 0)]
    for _ in range(most):
        last, here = known[passed[-1]], (passed[-1][0] + step[0], passed[-1][1] + step[1])
        if here not in known:
            return []
        before, now = apart[last], apart[known[here]]
        near = now <= CLEARANCE_M
        if (now < before - GROWS_M)[near].any() or (now < before + GROWS_M)[now <= 0].any():
            return []
        passed.append(here)
        if clear[known[here]]:
            return passed
    return []


def _over_connected(x: float, z: float, step_m: float, free: set[Cell]) -> Roam | None:
    """Return the floor of the free cells that are connected with (0, 0), or None if there are none."""
    reached = Grid(step_m, (x, z), frozenset(free | {(0, 0)})).component((0, 0))
    return None if len(reached) == 1 else Roam.over(x, z, step_m, reached)
