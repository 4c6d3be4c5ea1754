"""Actions that turn the agent's camera up and down, and raise and lower it.

Sources: contract, sections 2 and 4; AI2-THOR's PhysicsRemoteFPSAgentController (default) and LocobotFPSAgentController (locobot).
"""

from __future__ import annotations

from decimal import Decimal
from typing import Any

import numpy as np

from ovman_engine.actions.movement import full_circle
from ovman_engine.actions.registry import Failed, action
from ovman_engine.actions.values import Vector3
from ovman_engine.bodies.embodiment import DEFAULT, LOCOBOT
from ovman_engine.client.session import Session
from ovman_engine.world.world import Refused

LOOK_DEG = 30.0
"""Angle of a LookUp or LookDown that names none."""
BEYOND = "LookDownCantExceedMin"
"""AI2-THOR's error code at either limit."""


def _look(session: Session, degrees: float, sign: int) -> None:
    """Pitches the camera, `sign` 1 down and -1 up. Limits are compared to a tenth of a degree."""
    settings, agent = session.settings, session.world.agent
    horizon = round(agent.horizon_deg + sign * degrees, 9)
    if sign > 0 and round(horizon, 1) > settings.look_down_deg:
        raise Failed(f"can't look down beyond {settings.look_down_deg:g} degrees below the forward horizon", BEYOND)
    if sign < 0 and round(horizon, 1) < -settings.look_up_deg:
        raise Failed(f"can't look up beyond {settings.look_up_deg:g} degrees above the forward horizon", BEYOND)
    agent.horizon_deg = horizon + 0.0


def _checked(name: str, degrees: float) -> float:
    if degrees < 0:
        raise Refused(f"{name} action requires positive degree value. Invalid value used: {degrees:g}")
    # Single precision has seven decimal digits, and .NET's decimals take no more of them.
    if Decimal(f"{np.float32(degrees):.7g}") % Decimal("0.1") != 0:
        raise Refused(f"{name} action requires degree value to be a multiple of 0.1f")
    return round(degrees, 1) or LOOK_DEG


@action("LookDown", mode=DEFAULT.mode)
def look_down(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    _look(session, _checked("LookDown", degrees), 1)


@action("LookUp", mode=DEFAULT.mode)
def look_up(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    _look(session, _checked("LookUp", degrees), -1)


def _tilt(session: Session, degrees: float, sign: int) -> None:
    if degrees != 0:
        raise Refused("Must have degrees == 0 for now.")
    _look(session, LOOK_DEG, sign)


@action("LookDown", mode=LOCOBOT.mode)
def tilt_down(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    _tilt(session, degrees, 1)


@action("LookUp", mode=LOCOBOT.mode)
def tilt_up(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    _tilt(session, degrees, -1)


@action("RotateLook")
def rotate_look(session: Session, rotation: Vector3 | None = None, horizon: float = 0.0, **rest: Any) -> None:
    """Nothing is checked. A pitch is the same again after a full circle."""
    agent = session.world.agent
    agent.yaw_deg = full_circle(0.0 if rotation is None else rotation.y)
    pitch = full_circle(horizon)
    agent.horizon_deg = pitch - 360.0 if pitch > 180.0 else pitch


@action("Crouch", mode=DEFAULT.mode)
def crouch(session: Session) -> None:
    agent = session.world.agent
    if not agent.standing:
        raise Refused("Already crouching.")
    agent.standing = False


@action("Stand", mode=DEFAULT.mode)
def stand(session: Session) -> None:
    agent = session.world.agent
    if agent.standing:
        raise Refused("Already standing.")
    agent.standing = True
