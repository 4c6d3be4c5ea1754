"""Actions that put the agent at a pose.

Sources: contract, section 4; AI2-THOR's BaseFPSAgentController.teleportFull and the controllers' overloads of Teleport.
"""

from __future__ import annotations

import numpy as np

from ovman_engine.actions.movement import full_circle
from ovman_engine.actions.registry import Thrown, action, out_of_range
from ovman_engine.actions.values import Vector3
from ovman_engine.bodies.embodiment import DEFAULT, LOCOBOT
from ovman_engine.client.session import Session

GROUND_M = 0.05
"""Largest difference between a given height and the agent's height on the floor."""
EXACT_M = 1e-4
"""Tolerance of equal coordinates: clients may have stored them in single precision."""
UPRIGHT_DEG = 1e-2
"""Pitch and roll below which a rotation counts as a yaw."""


def _teleport(
    session: Session,
    position: Vector3 | None,
    rotation: Vector3 | None,
    horizon: float | None,
    standing: bool | None,
    force: bool,
) -> None:
    """Arguments that are None keep their value. On failure nothing changes."""
    world, agent, settings = session.world, session.world.agent, session.settings
    if not force and rotation is not None and max(abs(rotation.x), abs(rotation.z)) >= UPRIGHT_DEG:
        raise out_of_range(
            "No agents currently can change in pitch or roll. So, you must set rotation(x=0, y=yaw, z=0)."
            f" You gave {rotation.text(6)}."
        )
    low, high = -settings.look_up_deg, settings.look_down_deg
    if not force and horizon is not None and not low <= horizon <= high:
        raise out_of_range(f"Each horizon must be in [{low:g}:{high:g}]. You gave {horizon:g}.")
    target = agent.position
    if position is not None:
        target = position.array
        if not force:
            target = _on_ground(session, position)
    if not force and not np.array_equal(target, agent.position):
        blocker = world.blocker(target[[0, 2]], target[[0, 2]])
        if blocker is not None:
            raise Thrown("InvalidOperationException", f"Collided with: {blocker}.")
    agent.position = target
    if rotation is not None:
        agent.yaw_deg = full_circle(rotation.y)
    if horizon is not None:
        agent.horizon_deg = horizon + 0.0
    if standing is not None:
        agent.standing = standing


def _on_ground(session: Session, position: Vector3) -> np.ndarray:
    target = position.array
    if not session.in_bounds(target):
        raise out_of_range(f"Teleport position {position.text(6)} out of scene bounds! Ignore this by setting forceAction=true.")
    if session.settings.snap_to_grid and np.abs(session.snapped(target) - target).max() > EXACT_M:
        raise out_of_range(f"Teleport position {position.text(6)} is not on the grid of size {session.settings.grid_m:g}.")
    ground = float(session.world.plan.start[1])
    if abs(target[1] - ground) > GROUND_M:
        raise Thrown(
            "InvalidOperationException",
            "After teleporting and adjusting agent position to floor, there was too large a change"
            f"({abs(target[1] - ground):g} > {GROUND_M:g}) in the y component."
            " Consider using `forceAction=true` if you'd like to teleport anyway.",
        )
    target[1] = ground
    return target


@action("Teleport", mode=DEFAULT.mode)
def teleport(
    session: Session,
    position: Vector3 | None = None,
    rotation: Vector3 | None = None,
    horizon: float | None = None,
    standing: bool | None = None,
    forceAction: bool = False,
) -> None:
    """Teleport of the default agent."""
    _teleport(session, position, rotation, horizon, standing, forceAction)


@action("Teleport", mode=DEFAULT.mode)
def teleport_by_coordinates(
    session: Session,
    x: float,
    y: float,
    z: float,
    rotation: Vector3 | None = None,
    horizon: float | None = None,
    standing: bool | None = None,
    forceAction: bool = False,
) -> None:
    """Teleport with x, y and z in place of a position."""
    _teleport(session, Vector3(x, y, z), rotation, horizon, standing, forceAction)


@action("TeleportFull", mode=DEFAULT.mode)
def teleport_full(
    session: Session, position: Vector3, rotation: Vector3, horizon: float, standing: bool, forceAction: bool = False
) -> None:
    """TeleportFull of the default agent."""
    _teleport(session, position, rotation, horizon, standing, forceAction)


@action("TeleportFull", mode=DEFAULT.mode)
def teleport_full_by_coordinates(
    session: Session,
    x: float,
    y: float,
    z: float,
    rotation: Vector3,
    horizon: float,
    standing: bool,
    forceAction: bool = False,
) -> None:
    """TeleportFull with x, y and z in place of a position."""
    _teleport(session, Vector3(x, y, z), rotation, horizon, standing, forceAction)


# Locobot, which does not crouch


@action("Teleport", mode=LOCOBOT.mode)
def locobot_teleport(
    session: Session,
    position: Vector3 | None = None,
    rotation: Vector3 | None = None,
    horizon: float | None = None,
    forceAction: bool = False,
) -> None:
    """Teleport of the locobot."""
    _teleport(session, position, rotation, horizon, None, forceAction)


@action("Teleport", mode=LOCOBOT.mode)
def locobot_teleport_by_coordinates(
    session: Session,
    x: float,
    y: float,
    z: float,
    rotation: Vector3 | None = None,
    horizon: float | None = None,
    forceAction: bool = False,
) -> None:
    """Teleport of the locobot, with x, y and z in place of a position."""
    _teleport(session, Vector3(x, y, z), rotation, horizon, None, forceAction)


@action("TeleportFull", mode=LOCOBOT.mode)
def locobot_teleport_full(
    session: Session, position: Vector3, rotation: Vector3, horizon: float, forceAction: bool = False
) -> None:
    """TeleportFull of the locobot."""
    _teleport(session, position, rotation, horizon, None, forceAction)


@action("TeleportFull", mode=LOCOBOT.mode)
def locobot_teleport_full_by_coordinates(
    session: Session, x: float, y: float, z: float, rotation: Vector3, horizon: float, forceAction: bool = False
) -> None:
    """TeleportFull of the locobot, with x, y and z in place of a position."""
    _teleport(session, Vector3(x, y, z), rotation, horizon, None, forceAction)
