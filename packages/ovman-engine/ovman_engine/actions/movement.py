"""Actions that move the agent over the floor and turn it.

Sources: contract, sections 2 and 4; AI2-THOR's PhysicsRemoteFPSAgentController (default) and LocobotFPSAgentController (locobot).
Several of AI2-THOR's arguments are for agents with an arm, or for several agents, and change nothing here.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ovman_engine.actions.registry import Thrown, action
from ovman_engine.actions.values import MAX_COMPONENT, Vector3
from ovman_engine.bodies.embodiment import DEFAULT, LOCOBOT
from ovman_engine.bodies.passage import heading
from ovman_engine.client.session import Session
from ovman_engine.world.errors import Refused

TOWARDS_DEG = {"MoveAhead": 0.0, "MoveBack": 180.0, "MoveLeft": 270.0, "MoveRight": 90.0}
"""Direction of a move relative to the agent's yaw."""
CLOCKWISE = {"RotateRight": 1, "RotateLeft": -1}
NO_STRAFING = "Controller does not support horizontal movement by default. Set AllowHorizontalMovement to true on the Controller."


def _go(session: Session, towards_deg: float, length_m: float) -> None:
    """Move the agent straight, at a yaw relative to its own. Refused, with the agent unmoved, if the way is blocked."""
    world, agent = session.world, session.world.agent
    along_x, along_z = heading((agent.yaw_deg + towards_deg) % 360.0)
    step = np.array([along_x, 0.0, along_z]) * length_m
    target = agent.position + step
    if np.abs(target).max() > MAX_COMPONENT or not session.in_bounds(target):
        raise Refused(f"Scene bounds do not contain target position: {Vector3.of(target).text(2)}")
    blocker = world.blocker(agent.position[[0, 2]], target[[0, 2]])
    if blocker is not None:
        name = world.bodies[blocker].name if blocker in world.bodies else blocker
        raise Refused(f"{name} is blocking Agent 0 from moving by {Vector3.of(step).text(4)}.")
    agent.position = session.snapped(target)


def _move(session: Session, towards_deg: float, moveMagnitude: float | None, objectId: str, maxAgentsDistance: float) -> None:
    if moveMagnitude is not None and moveMagnitude <= 0:
        raise Thrown("InvalidOperationException", "moveMagnitude must be > 0")
    agent = session.world.agent
    before = agent.position
    _go(session, towards_deg, session.settings.grid_m if moveMagnitude is None else moveMagnitude)
    if objectId and maxAgentsDistance > 0 and (refusal := _too_far(session, objectId, maxAgentsDistance)):
        agent.position = before
        raise Refused(refusal)


def _too_far(session: Session, object_id: str, limit_m: float) -> str:
    body = session.world.bodies.get(object_id)
    if body is None:
        return f"No object with ID {object_id}"
    low, high = body.box.bounds()
    here = session.world.agent.position
    gap = np.maximum(np.maximum(low - here, here - high), 0.0)[[0, 2]]
    return f"Agent movement would bring it beyond the max distance of {object_id}" if np.hypot(*gap) > limit_m else ""


def _walker(name: str, towards_deg: float) -> None:
    """Register a move of the default agent."""

    @action(name, mode=DEFAULT.mode)
    def walk(
        session: Session,
        moveMagnitude: float | None = None,
        objectId: str = "",
        maxAgentsDistance: float = -1.0,
        forceAction: bool = False,
        manualInteract: bool = False,
        allowAgentsToIntersect: bool = False,
        speed: float = 1.0,
        fixedDeltaTime: float | None = None,
        returnToStart: bool = True,
        disableRendering: bool = True,
    ) -> None:
        _move(session, towards_deg, moveMagnitude, objectId, maxAgentsDistance)


for _name, _towards_deg in TOWARDS_DEG.items():
    _walker(_name, _towards_deg)


def _turn(session: Session, degrees: float) -> None:
    agent = session.world.agent
    agent.yaw_deg = full_circle(agent.yaw_deg + degrees)


def full_circle(degrees: float) -> float:
    """Return the angle in [0, 360), rounded to nine decimals: sums of decimal fractions are not exact."""
    return round(degrees % 360.0, 9) % 360.0


def _rotate(session: Session, degrees: float | None, sign: int) -> None:
    if degrees == 0:
        raise Thrown(
            "InvalidOperationException",
            "Cannot rotate by 0 degrees as this previously defaulted to rotating by a diferent amount.",
        )
    _turn(session, sign * (session.settings.turn_deg if degrees is None else degrees))


def _rotator(name: str, sign: int) -> None:
    """Register a rotation of the default agent."""

    @action(name, mode=DEFAULT.mode)
    def rotate(
        session: Session,
        degrees: float | None = None,
        manualInteract: bool = False,
        forceAction: bool = False,
        speed: float = 1.0,
        waitForFixedUpdate: bool = False,
        returnToStart: bool = True,
        disableRendering: bool = True,
        fixedDeltaTime: float = 0.02,
    ) -> None:
        _rotate(session, degrees, sign)


for _name, _sign in CLOCKWISE.items():
    _rotator(_name, _sign)


# Locobot


def _drive(session: Session, towards_deg: float, moveMagnitude: float | None, noise_m: float) -> None:
    """Move the agent with the noise of a wheeled robot: a small turn first, and an error along the way."""
    if moveMagnitude is not None and moveMagnitude <= 0:
        raise Thrown("InvalidOperationException", "moveMagnitude must be null or >= 0.")
    length_m = (session.settings.grid_m if moveMagnitude is None else moveMagnitude) + noise_m
    noise = session.settings.noise
    if noise is not None:
        _turn(session, session.random.gauss(*noise.swerve))
        length_m += session.random.gauss(*noise.move)
    _go(session, towards_deg, length_m)


@action("MoveAhead", mode=LOCOBOT.mode)
def drive_ahead(session: Session, moveMagnitude: float | None = None, noise: float = 0.0, forceAction: bool = False) -> None:
    """MoveAhead of the locobot."""
    _drive(session, 0.0, moveMagnitude, noise)


@action("MoveBack", mode=LOCOBOT.mode)
def drive_back(session: Session, moveMagnitude: float | None = None, noise: float = 0.0, forceAction: bool = False) -> None:
    """MoveBack of the locobot."""
    _drive(session, 180.0, moveMagnitude, noise)


@action("MoveLeft", mode=LOCOBOT.mode)
def drive_left(session: Session, moveMagnitude: float | None = None, noise: float = 0.0, forceAction: bool = False) -> None:
    """MoveLeft of the locobot: always refused."""
    raise Thrown("InvalidOperationException", NO_STRAFING)


@action("MoveRight", mode=LOCOBOT.mode)
def drive_right(session: Session, moveMagnitude: float | None = None, noise: float = 0.0, forceAction: bool = False) -> None:
    """MoveRight of the locobot: always refused."""
    raise Thrown("InvalidOperationException", NO_STRAFING)


def _swivel(session: Session, degrees: float, sign: int) -> None:
    noise = session.settings.noise
    error_deg = 0.0 if noise is None else session.random.gauss(*noise.turn)
    _turn(session, sign * (degrees or session.settings.turn_deg) + error_deg)


@action("RotateRight", mode=LOCOBOT.mode)
def swivel_right(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    """RotateRight of the locobot."""
    _swivel(session, degrees, 1)


@action("RotateLeft", mode=LOCOBOT.mode)
def swivel_left(session: Session, degrees: float = 0.0, **rest: Any) -> None:
    """RotateLeft of the locobot."""
    _swivel(session, degrees, -1)
