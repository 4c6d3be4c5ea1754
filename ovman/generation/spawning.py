"""Where a run begins: clear of what changes, and no success to begin with. Pure."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ovman.generation.placement import FreeFloor
from ovman.generation.script import Script
from ovman.records.change import Alteration
from ovman.records.geometry import Point, Spawn
from ovman.records.record import DEGREE_DECIMALS
from ovman.records.relation import Relation
from ovman.records.scene import SceneObject
from ovman.settings import Settings
from ovman.sim.world import AGENT_RADIUS_M

Box = tuple[Point, Point, float]
"""A rectangle on the floor: its centre and half extents, and what is kept from it; metres."""


def spawn(
    script: Script,
    target: SceneObject,
    first: Sequence[Alteration],
    second: Sequence[Alteration],
    floor: FreeFloor,
    constants: Settings,
    rng: np.random.Generator,
    others: Collection[str] = (),
) -> Spawn | None:
    """A spawn for the script's query about `target`; None if there is none.

    It is candidates.spawn_clearance_m away from where the target was and from all that the script puts somewhere, and farther
    than candidates.spawn_beyond_m from the answer, from nu(answer) and from the target's box; for MOVING the trials see to that.
    others: ids of the altered instances that the query is not about; what is put somewhere of these is no body to stand in.
    """
    clearance_m, beyond_m = constants.candidates.spawn_clearance_m, constants.candidates.spawn_beyond_m
    keep_from = [((target.position.x, target.position.z), clearance_m)]
    boxes: list[Box] = []
    sizes = {item.id: item.size for item in script.scene.objects}
    for alteration in second:
        if alteration.placement is not None and alteration.instance in others:
            size = sizes[alteration.instance]
            boxes.append((alteration.placement, (size.x / 2, size.z / 2), AGENT_RADIUS_M))
        elif alteration.placement is not None:
            keep_from.append((alteration.placement, clearance_m))
    if script.query.relation is not Relation.MOVING:
        at = script.answer(first, second)
        half = (target.size.x / 2, target.size.z / 2) if script.query.relation.current else (0.0, 0.0)
        boxes += [(at, half, beyond_m), (floor.nearest(at), (0.0, 0.0), beyond_m)]
    return spawn_away(floor, keep_from, constants.tour.headings, rng, boxes)


def spawn_away(
    floor: FreeFloor,
    keep_from: Sequence[tuple[Point, float]],
    headings: int,
    rng: np.random.Generator,
    boxes: Sequence[Box] = (),
) -> Spawn | None:
    """A reachable position at least so many metres from each of the points of `keep_from`, and farther than so many metres from
    each of `boxes`, looking along one of `headings`; None if no position is."""
    free = [
        (x, z)
        for x, z in floor.cells
        if all(np.hypot(x - kx, z - kz) >= metres for (kx, kz), metres in keep_from)
        and all(np.hypot(max(abs(x - kx) - hx, 0.0), max(abs(z - kz) - hz, 0.0)) > metres for (kx, kz), (hx, hz), metres in boxes)
    ]
    if not free:
        return None
    x, z = free[int(rng.integers(len(free)))]
    yaw_deg = round(float(360.0 / headings * rng.integers(headings)), DEGREE_DECIMALS)
    return Spawn(x=round(float(x), 4), z=round(float(z), 4), yaw_deg=yaw_deg)
