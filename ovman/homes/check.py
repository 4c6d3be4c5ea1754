"""Whether a house can be lived in by a robot: every room is reached, nothing overlaps, and nothing moves by itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import ndimage

from ovman_engine.bodies.body import Body
from ovman_engine.plan.house import HouseRoom
from ovman_engine.plan.house_json import read
from ovman_engine.plan.houseplan import plan_of
from ovman_engine.world.world import World

OVERLAP_M = 0.01
"""Deepest overlap of two boxes"""
MOVED_M = 0.02
"""How far a thing may move when everything is woken"""
LIFT_M = 0.003
"""How far things are lifted before they are woken"""
WOKEN_S = 3.0
"""Simulated time that woken things get to come to rest"""
STEP_M = 0.25
"""Spacing of the navigation grid"""
CELLS = 8
"""Least number of cells of the grid in a room"""
START_M = 0.5
"""The floor stays free this far around the agent's start, along x and z"""


@dataclass(frozen=True)
class Report:
    """The findings of `check`. faults: why the house fails, none if it is sound."""

    faults: tuple[str, ...]
    areas_m2: Mapping[str, float]
    """Area of each room"""
    cells: Mapping[str, int]
    """Number of cells of the navigation grid that the agent reaches in each room"""
    woken: int
    """Number of things that physics moves"""
    moved_m: float
    """How far the thing moved that moved farthest"""

    @property
    def ok(self) -> bool:
        """Whether the house is sound."""
        return not self.faults


def check(house: Mapping[str, Any]) -> Report:
    """Load a house in the engine and examine it. Raises InvalidHouse for a value that is not a house."""
    plan = plan_of(read(house))
    world = World(plan)
    cells = _cells(world)
    faults = [f"room {name} is not reached" for name, count in cells.items() if count < CELLS]
    faults += [*_cut_off(world), *_overlaps(world), *_blocked(world)]
    woken, moves = _wake(world)
    faults += [f"{name} moves {moved:.3f} m when it is woken" for name, moved in moves.items() if moved > MOVED_M]
    areas = {room.name: _area(room.polygon) for room in plan.house.rooms}
    return Report(tuple(faults), areas, cells, woken, max(moves.values(), default=0.0))


def _area(polygon: np.ndarray) -> float:
    x, z = polygon.T
    return abs(float(x @ np.roll(z, -1) - z @ np.roll(x, -1))) / 2


def _cells(world: World) -> dict[str, int]:
    points = np.array(world.reachable(STEP_M)).reshape(-1, 3)[:, [0, 2]]
    return {room.name: int(room.contains(points).sum()) for room in world.plan.house.rooms}


def _cut_off(world: World) -> Iterator[str]:
    """Yield a fault if the points of the grid through the agent's start that are in a room and free are not one area."""
    rooms: tuple[HouseRoom, ...] = world.plan.house.rooms
    corners = np.concatenate([room.polygon for room in rooms])
    start = world.plan.start[[0, 2]]
    axes = [
        np.arange(np.ceil((low - at) / STEP_M), np.floor((high - at) / STEP_M) + 1) * STEP_M + at
        for low, high, at in zip(corners.min(axis=0), corners.max(axis=0), start, strict=True)
    ]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    obstacles, _ = world.obstacles()
    free = np.any([room.contains(points) for room in rooms], axis=0)
    for index in map(tuple, np.argwhere(free)):
        free[index] = not obstacles.overlapping(points[index]).any()
    _, parts = ndimage.label(free)
    if parts > 1:
        yield f"the floor has {parts} parts"


def _overlaps(world: World) -> Iterator[str]:
    """Yield pairs of objects whose boxes overlap, and things whose pieces overlap those of what holds them."""
    bodies = [b for b in world.bodies.values() if b.obj.type not in ("Floor", "Window", "Doorway", "Doorframe")]
    bounds = np.array([np.concatenate(b.box.bounds()) for b in bodies]).reshape(-1, 6)
    for k, body in enumerate(bodies):
        depth = np.minimum(bounds[k, 3:], bounds[:k, 3:]) - np.maximum(bounds[k, :3], bounds[:k, :3])
        for other in (bodies[j] for j in np.flatnonzero((depth > OVERLAP_M).all(axis=1))):
            if not _holds(body, other) and not _holds(other, body) and _intersect(body, other):
                yield f"{body.object_id} overlaps {other.object_id}"
    names = [b.object_id for b in bodies if b.dynamic]
    if names:
        with world.trial(names) as model:
            model.forward()
            for name in names:
                for obstacle, depth_m in model.touching(name):
                    if depth_m > OVERLAP_M and obstacle != "Floor":
                        yield f"{name} is {depth_m:.3f} m in {obstacle}"


def _holds(body: Body, other: Body) -> bool:
    return body.object_id in other.obj.parents


def _intersect(body: Body, other: Body) -> bool:
    """Whether two boxes, which may be turned about y, overlap by more than OVERLAP_M."""
    for axis in (*body.box.rotation.T, *other.box.rotation.T):
        reach = sum(float(np.abs(b.box.rotation.T @ axis) @ b.box.half) for b in (body, other))
        if abs(float((body.box.centre - other.box.centre) @ axis)) > reach - OVERLAP_M:
            return False
    return True


def _blocked(world: World) -> Iterator[str]:
    """Yield objects at the agent's start."""
    start = world.plan.start
    for body in world.bodies.values():
        low, high = body.box.bounds()
        if body.obj.type == "Floor" or low[1] > start[1]:
            continue
        if (low[[0, 2]] < start[[0, 2]] + START_M).all() and (high[[0, 2]] > start[[0, 2]] - START_M).all():
            yield f"{body.object_id} stands at the start"


def _wake(world: World) -> tuple[int, dict[str, float]]:
    """Lift everything that physics moves by LIFT_M and let it go. Return how many things, and how far each moved, metres.

    The engine leaves what hangs in the air as the house has it where it is, so nothing may stay at its exact place.
    """
    bodies = {b.name: b for b in world.bodies.values() if b.dynamic}
    before = {name: b.box.centre.copy() for name, b in bodies.items()}
    lift = np.array([0.0, LIFT_M, 0.0])
    poses = [{"objectName": name, "position": b.pose.position + lift, "rotation": b.pose.rotation} for name, b in bodies.items()]
    if not poses:
        return 0, {}
    world.set_poses(poses, stationary=False)
    world.advance(WOKEN_S)
    after = {b.name: b.box.centre for b in world.bodies.values()}
    return len(poses), {name: float(np.linalg.norm(after[name] - at)) for name, at in before.items()}
