"""Actions that pitch, lower and raise the agent's camera.

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
from ovman_engine.world.errors import Refused

LOOK_DEG = 30.0
"""Default angle of LookUp and LookDown."""
BEYOND = "LookDownCantExceedMin"
"""AI2-THOR's error code at the upper and the lower limit."""


def _look(session: Session, degrees: float, sign: int) -> None:
    """Pitches the camera down (`sign` 1) or up (-1). Limits are compared to a tenth of a degree, as AI2-THOR does."""
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
    # AI2-THOR converts a single-precision number to a .NET decimal, which keeps seven digits of it.
    if Decimal(f"{np.float32(degrees):.7g}") % Decimal("0.1") != 0:
        raise Refused(f"{name} action requires degree value to be a multiple of 0.1f")
    return round(degrees, 1) or LOOK_DEG


@action("LookDown", mode=DEFAULT.mode)
def look_down(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    """LookDown of the default agent."""
    _look(session, _checked("LookDown", degrees), 1)


@action("LookUp", mode=DEFAULT.mode)
def look_up(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    """LookUp of the default agent."""
    _look(session, _checked("LookUp", degrees), -1)


def _tilt(session: Session, degrees: float, sign: int) -> None:
    if degrees != 0:
        raise Refused("Must have degrees == 0 for now.")
    _look(session, LOOK_DEG, sign)


@action("LookDown", mode=LOCOBOT.mode)
def tilt_down(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    """LookDown of the locobot, by a fixed angle."""
    _tilt(session, degrees, 1)


@action("LookUp", mode=LOCOBOT.mode)
def tilt_up(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    """LookUp of the locobot, by a fixed angle."""
    _tilt(session, degrees, -1)


@action("RotateLook")
def rotate_look(session: Session, rotation: Vector3 | None = None, horizon: float = 0.0, **rest: Any) -> None:
    """RotateLook: sets yaw and horizon without any check. Horizons wrap around after a full circle."""
    agent = session.world.agent
    agent.yaw_deg = full_circle(0.0 if rotation is None else rotation.y)
    pitch = full_circle(horizon)
    agent.horizon_deg = pitch - 360.0 if pitch > 180.0 else pitch


@action("Crouch", mode=DEFAULT.mode)
def crouch(session: Session) -> None:
    """Crouch: lowers the camera. Refused while it is lowered."""
    agent = session.world.agent
    if not agent.standing:
        raise Refused("Already crouching.")
    agent.standing = False


@action("Stand", mode=DEFAULT.mode)
def stand(session: Session) -> None:
    """Stand: raises the camera. Refused while it is raised."""
    agent = session.world.agent
    if agent.standing:
        raise Refused("Already standing.")
    agent.standing = True
