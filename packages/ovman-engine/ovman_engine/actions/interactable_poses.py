"""Poses from which an object is visible and interactable. The agent does not move.

Sources: contract, section 4; AI2-THOR's getInteractablePoses of the default agent and of the locobot.
"""

from __future__ import annotations

from itertools import islice
from typing import Any

import numpy as np

from ovman_engine.actions.navigation import ERROR_M, MAX_VIEWPOINTS
from ovman_engine.actions.reachable import reachable_positions
from ovman_engine.actions.registry import Thrown, action, out_of_range
from ovman_engine.actions.values import Vector3
from ovman_engine.bodies.embodiment import DEFAULT, LOCOBOT
from ovman_engine.client.session import Session
from ovman_engine.sight.interactable import poses
from ovman_engine.world.errors import Refused

HORIZONS_DEG = (-30.0, 0.0, 30.0, 60.0)
"""Default horizons."""
UNLIMITED = 2**31 - 1


def _clear(session: Session, places: np.ndarray) -> np.ndarray:
    """(P,) bool: at which of the positions (P, 3) the agent collides with nothing, so that it can be teleported there."""
    obstacles, _ = session.world.obstacles()
    gaps = obstacles.distances(places[:, [0, 2]], float(obstacles.reach.max(initial=0.0)))
    return (gaps >= obstacles.reach).all(axis=1) | (places == session.world.agent.position).all(axis=1)


def _poses(
    session: Session,
    object_id: str,
    positions: list[Vector3] | None,
    rotations: list[float] | None,
    horizons: list[float] | None,
    standings: list[bool | None] | None,
    max_distance: float | None,
    max_poses: int,
) -> list[dict[str, Any]]:
    world, s = session.world, session.settings
    step = s.turn_deg
    if rotations is None and abs(360.0 / step - round(360.0 / step)) > ERROR_M:
        raise Thrown(
            "InvalidOperationException",
            f"360 % rotateStepDegrees (360 % {step:g} != 0) must be 0, unless 'rotations: float[]' is overwritten.",
        )
    if max_poses <= 0:
        raise out_of_range("maxPoses must be > 0.")
    if max_distance is not None and max_distance <= 0:
        raise out_of_range("maxDistance must be >= 0 meters from the object.")
    distance = s.visibility_m if max_distance is None else max_distance
    session.body(object_id)
    low, high = -s.look_up_deg, s.look_down_deg
    if horizons is None:
        horizons = [h for h in HORIZONS_DEG if low <= h <= high]
    elif outside := [h for h in horizons if not low <= h <= high]:
        raise Thrown("ArgumentException", f"Each horizon must be in [{low:g}:{high:g}]. You gave {outside[0]:g}.")
    if positions is None:
        positions = [Vector3(**p) for p in reachable_positions(session)]
    places = [p.array for p in positions]
    if places:
        places = [p for p, clear in zip(places, _clear(session, np.array(places)), strict=True) if clear]
    if rotations is None:
        offset = round(world.agent.yaw_deg % step)
        rotations = [float(offset + k * step) for k in range(round(360.0 / step))]
    if not (horizons and rotations and standings) or positions == []:
        raise Thrown("InvalidOperationException", "Every degree of freedom must have at least 1 valid value.")
    if len(places) * len(standings) > MAX_VIEWPOINTS:
        raise Refused(f"GetInteractablePoses looks from at most {MAX_VIEWPOINTS} places, not {len(places) * len(standings)}.")
    found = poses(
        session.sight,
        object_id,
        world.agent,
        places,
        rotations,
        horizons,
        standings,
        distance,
        s.field_of_view_deg,
        session.width / session.height,
    )
    return list(islice(found, max_poses))


@action("GetInteractablePoses", mode=DEFAULT.mode)
def interactable_poses(
    session: Session,
    objectId: str,
    positions: list[Vector3] | None = None,
    rotations: list[float] | None = None,
    horizons: list[float] | None = None,
    standings: list[bool] | None = None,
    maxDistance: float | None = None,
    maxPoses: int = UNLIMITED,
) -> list[dict[str, Any]]:
    """GetInteractablePoses of the default agent."""
    stances: list[bool | None] = [False, True] if standings is None else list(standings)
    return _poses(session, objectId, positions, rotations, horizons, stances, maxDistance, maxPoses)


@action("GetInteractablePoses", mode=LOCOBOT.mode)
def interactable_poses_of_a_locobot(
    session: Session,
    objectId: str,
    positions: list[Vector3] | None = None,
    rotations: list[float] | None = None,
    horizons: list[float] | None = None,
    maxDistance: float | None = None,
    maxPoses: int = UNLIMITED,
) -> list[dict[str, Any]]:
    """GetInteractablePoses of the locobot, which does not crouch."""
    return _poses(session, objectId, positions, rotations, horizons, [None], maxDistance, maxPoses)
