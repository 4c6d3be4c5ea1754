"""Where the agent can go. Sources: contract, sections 2 and 4; AI2-THOR's BaseFPSAgentController.getReachablePositions."""

from __future__ import annotations

import math

from ovman_engine.actions.registry import Thrown, action
from ovman_engine.actions.values import Vector3
from ovman_engine.client.session import Session
from ovman_engine.world.world import Refused

MANY_STEPS = 10_000
"""Area in square metres within which reachable positions are looked for unless an action says otherwise."""
FINEST_M = 0.01
"""Smallest distance between positions that are looked for: the largest rooms take seconds then."""


@action("GetReachablePositions")
def reachable_positions(
    session: Session, maxStepCount: int | None = None, directionsRelativeAgent: bool = False, gridSize: float | None = None
) -> list[dict[str, float]]:
    step = session.settings.grid_m if gridSize is None else gridSize
    if step < FINEST_M:
        raise Refused(f"grid size must be at least {FINEST_M:g} to look for reachable positions, not {step:g}.")
    found = session.world.reachable(step, session.world.agent.yaw_deg if directionsRelativeAgent else 0.0)
    if len(found) > math.floor((MANY_STEPS if maxStepCount is None else maxStepCount) / (step * step)):
        raise Thrown("InvalidOperationException", "Too many steps taken in GetReachablePositions.")
    return [Vector3.of(p).to_json() for p in found]
