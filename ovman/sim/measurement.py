"""What is measured where an agent stops (Eq. 4) and around an answer (Algorithm 1, line 4). Distances in metres, floor plane."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from ovman.navigation.grid import Cell, Grid
from ovman.records.geometry import Point, Spawn
from ovman.records.run import InstanceTerms, Terms
from ovman.sim.session import AgentPose, Session, bearing_deg


def box_distance_m(x: float, z: float, metadata: Mapping[str, Any]) -> float:
    """Distance from (x, z) to the floor-plane projection of an object's axis-aligned box; 0 inside."""
    centre, size = metadata["axisAlignedBoundingBox"]["center"], metadata["axisAlignedBoundingBox"]["size"]
    return math.hypot(max(abs(x - centre["x"]) - size["x"] / 2, 0.0), max(abs(z - centre["z"]) - size["z"] / 2, 0.0))


@dataclass(frozen=True)
class ReachableRegion:
    """The navigation grid after the change, the cell of the spawn, and the component of the grid that the spawn belongs to."""

    grid: Grid
    spawn: Cell
    component: frozenset[Cell]

    @staticmethod
    def around(session: Session, spawn: AgentPose, step_m: float) -> ReachableRegion:
        """Return the region around the agent, which must stand at the spawn, on a new grid with spacing `step_m`."""
        grid = Grid.from_positions(session.reachable(), step_m)
        cell = grid.nearest(spawn.x, spawn.z)
        return ReachableRegion(grid, cell, frozenset(grid.component(cell)))

    def navigable(self, x: float, z: float) -> Point:
        """nu(a): centre of the cell of the spawn's component nearest to (x, z)."""
        return self.grid.centre(self.grid.nearest(x, z, within=self.component))


def at_stop(
    session: Session,
    relation_is_past: bool,
    target: str,
    answer: Point,
    navigable: Point,
    pitches_deg: tuple[int, ...],
    instances: Collection[str] = (),
) -> tuple[Terms, Mapping[str, InstanceTerms]]:
    """Return the terms of Eq. 4 at the agent's pose, and those of each of `instances`; the sweep leaves the agent looking down.

    navigable: nu(a). Past relations have no object terms (None). instances: ids of further objects to measure in the same
    images, for an agent whose own task is to reach any of them.
    """
    stop = session.pose
    objects, names = session.objects, sorted({*instances} | (set() if relation_is_past else {target}))
    seen = session.sweep(names, stop, pitches_deg) if names else {}
    of_objects = {
        k: InstanceTerms(box_distance_m=round(box_distance_m(stop.x, stop.z, objects[k]), 4), visible_px=seen[k]) for k in names
    }
    of_target = None if relation_is_past else of_objects[target]
    terms = Terms(
        stop=Spawn(x=round(stop.x, 4), z=round(stop.z, 4), yaw_deg=round(stop.yaw_deg, 2)),
        box_distance_m=None if of_target is None else of_target.box_distance_m,
        answer_distance_m=round(math.dist((stop.x, stop.z), answer), 4),
        navigable_distance_m=round(math.dist((stop.x, stop.z), navigable), 4),
        visible_px=None if of_target is None else of_target.visible_px,
    )
    return terms, {k: of_objects[k] for k in sorted(instances)}


def from_navigable(
    session: Session, target: str, answer: Point, region: ReachableRegion, pitches_deg: tuple[int, ...]
) -> dict[int, int]:
    """Mask sizes of the target in pixels by pitch over the look-down sweep from nu(a), facing the answer."""
    x, z = region.navigable(*answer)
    return session.sweep([target], AgentPose(x, z, bearing_deg(x, z, *answer)), pitches_deg)[target]
