"""Positions that the agent can reach.

Sources: contract, sections 2 and 4; AI2-THOR's BaseFPSAgentController.getReachablePositions.
"""

from __future__ import annotations

import math

from ovman_engine.actions.registry import Thrown, action
from ovman_engine.actions.values import Vector3
from ovman_engine.client.session import Session
from ovman_engine.world.errors import Refused

MAX_AREA_M2 = 10_000
"""Default area, square metres, within which reachable positions are searched."""
MIN_GRID_M = 0.01
"""Smallest spacing of the positions: the largest rooms then take seconds."""


@action("GetReachablePositions")
def reachable_positions(
    session: Session, maxStepCount: int | None = None, directionsRelativeAgent: bool = False, gridSize: float | None = None
) -> list[dict[str, float]]:
    """GetReachablePositions: positions that moves of the grid's spacing reach, the agent's own first.

    The lattice follows the axes of the world, or the agent's yaw if `directionsRelativeAgent`.
    """
    step = session.settings.grid_m if gridSize is None else gridSize
    if step < MIN_GRID_M:
        raise Refused(f"grid size must be at least {MIN_GRID_M:g} to look for reachable positions, not {step:g}.")
    found = session.world.reachable(step, session.world.agent.yaw_deg if directionsRelativeAgent else 0.0)
    if len(found) > math.floor((MAX_AREA_M2 if maxStepCount is None else maxStepCount) / (step * step)):
        raise Thrown("InvalidOperationException", "Too many steps taken in GetReachablePositions.")
    return [Vector3.of(p).to_json() for p in found]
