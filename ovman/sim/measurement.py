"""What is measured where an agent stops (Eq. 4) and around an answer (Algorithm 1, line 4). Distances in metres, floor plane."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from ovman.navigation import Cell, Grid
from ovman.sim.session import AgentPose, Session, bearing_deg


def box_distance_m(x: float, z: float, metadata: Mapping[str, Any]) -> float:
    """Distance from (x, z) to the floor-plane projection of an object's axis-aligned box; 0 inside."""
    centre, size = metadata["axisAlignedBoundingBox"]["center"], metadata["axisAlignedBoundingBox"]["size"]
    return math.hypot(max(abs(x - centre["x"]) - size["x"] / 2, 0.0), max(abs(z - centre["z"]) - size["z"] / 2, 0.0))


@dataclass(frozen=True)
class Ground:
    """The navigation grid after the change and the part of it that the spawn belongs to."""

    grid: Grid
    spawn: Cell
    component: frozenset[Cell]

    @staticmethod
    def around(session: Session, spawn: AgentPose, step_m: float) -> Ground:
        """Recomputed around the agent, which must stand at the spawn."""
        grid = Grid.from_positions(session.reachable(), step_m)
        cell = grid.nearest(spawn.x, spawn.z)
        return Ground(grid, cell, frozenset(grid.component(cell)))

    def navigable(self, x: float, z: float) -> tuple[float, float]:
        """nu(a): centre of the cell of the spawn's component nearest to (x, z)."""
        return self.grid.centre(self.grid.nearest(x, z, within=self.component))


def at_stop(
    session: Session,
    relation_is_past: bool,
    target: str,
    answer: tuple[float, float],
    navigable: tuple[float, float],
    pitches_deg: tuple[int, ...],
    instances: Collection[str] = (),
) -> dict[str, Any]:
    """The terms of Eq. 4 at the agent's pose; the sweep leaves it looking down. Past relations have no object terms (null).

    navigable: nu(a). instances: others to be measured in the same way, for an agent whose own task is to reach any of them;
    their terms are under "instances" if there are any.
    """
    stop = session.pose
    objects, names = session.objects, sorted({*instances} | (set() if relation_is_past else {target}))
    seen = session.sweeps(names, stop, pitches_deg) if names else {}
    terms = {
        k: {
            "box_distance_m": round(box_distance_m(stop.x, stop.z, objects[k]), 4),
            "visible_px": {str(p): n for p, n in seen[k].items()},
        }
        for k in names
    }
    of_target = {"box_distance_m": None, "visible_px": None} if relation_is_past else terms[target]
    measured = {
        "stop": {"x": round(stop.x, 4), "z": round(stop.z, 4), "yaw_deg": round(stop.yaw_deg, 2)},
        "box_distance_m": of_target["box_distance_m"],
        "answer_distance_m": round(math.dist((stop.x, stop.z), answer), 4),
        "navigable_distance_m": round(math.dist((stop.x, stop.z), navigable), 4),
        "visible_px": of_target["visible_px"],
    }
    return measured | {"instances": {k: terms[k] for k in sorted(instances)}} if instances else measured


def from_navigable(
    session: Session, target: str, answer: tuple[float, float], ground: Ground, pitches_deg: tuple[int, ...]
) -> dict[str, int]:
    """Mask sizes of the target over the look-down sweep from nu(a), facing the answer."""
    x, z = ground.navigable(*answer)
    return {str(p): n for p, n in session.sweep(target, AgentPose(x, z, bearing_deg(x, z, *answer)), pitches_deg).items()}
