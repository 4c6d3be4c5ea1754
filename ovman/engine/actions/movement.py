"""Actions that move the agent and its camera, and what it can reach."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ovman.engine.actions.registry import Failed, Thrown, action, out_of_range
from ovman.engine.actions.values import FARTHEST, Vector3
from ovman.engine.engine import Engine
from ovman.engine.world import Refused

LOOK_DEG = 30.0
"""Angle of a LookUp or LookDown that names none."""
GROUND_M = 0.05
"""How far from its height above the floor the agent may be put."""
MANY_STEPS = 10_000.0
"""Area in square metres within which reachable positions are looked for unless an action says otherwise."""
EXACT_M = 1e-4
"""How near a coordinate must be to another to be the same: single precision, which clients may have gone through."""


def _direction(yaw_deg: float) -> np.ndarray:
    """Unit vector along a yaw, exact where it goes along an axis of the world, so that a walk stays on its lattice."""
    if yaw_deg % 90 == 0:
        return np.array([(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0)][int(yaw_deg // 90) % 4])
    return np.array([math.sin(math.radians(yaw_deg)), 0.0, math.cos(math.radians(yaw_deg))])


def _move(engine: Engine, heading_deg: float, magnitude: float | None, force: bool) -> None:
    world, agent = engine.world, engine.world.agent
    length = magnitude if magnitude is not None and magnitude > 0 else engine.settings.grid_m
    step = _direction((agent.yaw_deg + heading_deg) % 360.0) * length
    target = agent.position + step
    if np.abs(target).max() > FARTHEST:
        raise Refused(f"Scene bounds do not contain target position: {Vector3.of(target).text(2)}")
    if not force:
        if not engine.in_bounds(target):
            raise Refused(f"Scene bounds do not contain target position: {Vector3.of(target).text(2)}")
        blocker = world.blocker(agent.position[[0, 2]], target[[0, 2]])
        if blocker is not None:
            name = world.bodies[blocker].name if blocker in world.bodies else blocker
            raise Refused(f"{name} is blocking Agent 0 from moving by {Vector3.of(step).text(4)}.")
    agent.position = engine.snapped(target)


@action("MoveAhead")
def move_ahead(engine: Engine, moveMagnitude: float | None = None, forceAction: bool = False) -> None:
    _move(engine, 0.0, moveMagnitude, forceAction)


@action("MoveBack")
def move_back(engine: Engine, moveMagnitude: float | None = None, forceAction: bool = False) -> None:
    _move(engine, 180.0, moveMagnitude, forceAction)


@action("MoveLeft")
def move_left(engine: Engine, moveMagnitude: float | None = None, forceAction: bool = False) -> None:
    _move(engine, 270.0, moveMagnitude, forceAction)


@action("MoveRight")
def move_right(engine: Engine, moveMagnitude: float | None = None, forceAction: bool = False) -> None:
    _move(engine, 90.0, moveMagnitude, forceAction)


def _turn(engine: Engine, degrees: float | None, sign: int) -> None:
    if degrees == 0:
        raise Thrown(
            "InvalidOperationException",
            "Cannot rotate by 0 degrees as this previously defaulted to rotating by a diferent amount.",
        )
    agent = engine.world.agent
    agent.yaw_deg = _full_circle(agent.yaw_deg + sign * (engine.settings.turn_deg if degrees is None else degrees))


def _full_circle(degrees: float) -> float:
    """The angle in [0, 360), free of the last bits that sums of decimal fractions leave."""
    return round(degrees % 360.0, 9) % 360.0


@action("RotateRight")
def rotate_right(engine: Engine, degrees: float | None = None, forceAction: bool = False) -> None:
    _turn(engine, degrees, 1)


@action("RotateLeft")
def rotate_left(engine: Engine, degrees: float | None = None, forceAction: bool = False) -> None:
    _turn(engine, degrees, -1)


def _look(engine: Engine, name: str, degrees: float, sign: int) -> None:
    settings, agent = engine.settings, engine.world.agent
    if degrees < 0:
        raise Refused(f"{name} action requires positive degree value. Invalid value used: {degrees:g}")
    if abs(degrees * 10 - round(degrees * 10)) > EXACT_M:
        raise Refused(f"{name} action requires degree value to be a multiple of 0.1f")
    horizon = round(agent.horizon_deg + sign * (degrees or LOOK_DEG), 1)
    if sign > 0 and horizon > settings.look_down_deg:
        message = f"can't look down beyond {settings.look_down_deg:g} degrees below the forward horizon"
        raise Failed(message, "LookDownCantExceedMin")
    if sign < 0 and horizon < -settings.look_up_deg:
        message = f"can't look up beyond {settings.look_up_deg:g} degrees above the forward horizon"
        raise Failed(message, "LookUpCantExceedMax")
    agent.horizon_deg = horizon + 0.0


@action("LookDown")
def look_down(engine: Engine, degrees: float = 0.0, **rest: Any) -> None:
    _look(engine, "LookDown", degrees, 1)


@action("LookUp")
def look_up(engine: Engine, degrees: float = 0.0, **rest: Any) -> None:
    _look(engine, "LookUp", degrees, -1)


def _teleport(
    engine: Engine, position: Vector3 | None, rotation: Vector3 | None, horizon: float | None, standing: bool | None, force: bool
) -> None:
    """What is None stays as it is. On failure nothing changes."""
    world, agent, settings = engine.world, engine.world.agent, engine.settings
    if rotation is not None and (abs(rotation.x) > EXACT_M or abs(rotation.z) > EXACT_M):
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
            target = _on_ground(engine, position)
    if not force:
        blocker = world.blocker(target[[0, 2]], target[[0, 2]])
        if blocker is not None and not np.array_equal(target, agent.position):
            raise Thrown("InvalidOperationException", f"Collided with: {blocker}.")
    agent.position = target
    if rotation is not None:
        agent.yaw_deg = _full_circle(rotation.y)
    if horizon is not None:
        agent.horizon_deg = horizon + 0.0
    if standing is not None:
        agent.standing = standing


def _on_ground(engine: Engine, position: Vector3) -> np.ndarray:
    target = position.array
    if not engine.in_bounds(target):
        raise out_of_range(f"Teleport position {position.text(6)} out of scene bounds! Ignore this by setting forceAction=true.")
    if engine.settings.snap_to_grid and np.abs(engine.snapped(target) - target).max() > EXACT_M:
        raise out_of_range(f"Teleport position {position.text(6)} is not on the grid of size {engine.settings.grid_m:g}.")
    ground = float(engine.world.plan.start[1])
    if abs(target[1] - ground) > GROUND_M:
        raise Thrown(
            "InvalidOperationException",
            "After teleporting and adjusting agent position to floor, there was too large a change"
            f"({abs(target[1] - ground):g} > {GROUND_M:g}) in the y component."
            " Consider using `forceAction=true` if you'd like to teleport anyway.",
        )
    target[1] = ground
    return target


@action("Teleport")
def teleport(
    engine: Engine,
    position: Vector3 | None = None,
    rotation: Vector3 | None = None,
    horizon: float | None = None,
    standing: bool | None = None,
    forceAction: bool = False,
) -> None:
    _teleport(engine, position, rotation, horizon, standing, forceAction)


@action("Teleport")
def teleport_by_coordinates(
    engine: Engine,
    x: float,
    y: float,
    z: float,
    rotation: Vector3 | None = None,
    horizon: float | None = None,
    standing: bool | None = None,
    forceAction: bool = False,
) -> None:
    _teleport(engine, Vector3(x, y, z), rotation, horizon, standing, forceAction)


@action("TeleportFull")
def teleport_full(
    engine: Engine, position: Vector3, rotation: Vector3, horizon: float, standing: bool, forceAction: bool = False
) -> None:
    _teleport(engine, position, rotation, horizon, standing, forceAction)


@action("TeleportFull")
def teleport_full_by_coordinates(
    engine: Engine,
    x: float,
    y: float,
    z: float,
    rotation: Vector3,
    horizon: float,
    standing: bool,
    forceAction: bool = False,
) -> None:
    _teleport(engine, Vector3(x, y, z), rotation, horizon, standing, forceAction)


@action("GetReachablePositions")
def reachable_positions(
    engine: Engine, gridSize: float | None = None, maxStepCount: int | None = None, directionsRelativeAgent: bool = False
) -> list[dict[str, float]]:
    step = engine.settings.grid_m if gridSize is None else gridSize
    if step <= 0:
        raise Refused("grid size must be in the range (0,5]")
    yaw = engine.world.agent.yaw_deg
    if directionsRelativeAgent and yaw % 90 != 0:
        raise Refused(f"directionsRelativeAgent needs an agent that looks along an axis of the world, not {yaw:g} degrees.")
    found = engine.world.reachable(step)
    if len(found) > math.floor((MANY_STEPS if maxStepCount is None else maxStepCount) / (step * step)):
        raise Refused("Too many steps taken in GetReachablePositions.")
    return [Vector3.of(p).to_json() for p in found]
