"""Shortest paths to an object or a point. The agent does not move.

Sources: contract, section 4; AI2-THOR's BaseFPSAgentController (getShortestPath, SafelyComputeNavMeshPath).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from ovman_engine.actions.registry import Thrown, action, null_reference
from ovman_engine.actions.values import Vector3
from ovman_engine.bodies.body import Agent
from ovman_engine.bodies.passage import reachable
from ovman_engine.client.session import Session
from ovman_engine.sight.interactable import reaching
from ovman_engine.sight.shortest_path import SNAP_M, Floor, shortest
from ovman_engine.sight.visibility import axes, in_picture
from ovman_engine.world.errors import Refused

ERROR_M = 1e-4
"""Default of allowedError: how far the ends of a path may lie beside the navigation mesh."""
MAX_SNAP_M = 1.0
"""Largest distance of a point from the mesh, whatever allowedError is."""
MIN_STEP_M = 0.05
"""Smallest step of the search for a position from which an object is visible."""
MAX_VIEWPOINTS = 20_000
"""Largest number of camera positions that one action tries: the client is waiting."""


def _of_type_or_id(session: Session, object_type: str | None, object_id: str | None) -> str:
    if object_id:
        return session.body(object_id).object_id
    if not object_type:
        raise Thrown("ArgumentNullException", "Value cannot be null.\nParameter name: key")
    wanted = object_type.replace(" ", "").lower()
    found = [b.object_id for b in session.world.bodies.values() if not b.removed and b.obj.type.lower() == wanted]
    if not found:
        raise Refused(f"Cannot find sim object: Object type '{object_type}' was not found in the scene.")
    if len(found) > 1:
        raise Refused(f"Multiple objects of type '{object_type}' were found in the scene, cannot disambiguate.")
    return found[0]


def _floor(session: Session) -> Floor:
    world = session.world
    obstacles, names = world.obstacles()
    stays = np.array([name not in world.bodies or not world.bodies[name].dynamic for name in names], dtype=bool)
    x_0, z_0, x_1, z_1 = world.room.rectangle
    return Floor(obstacles.take(stays & (obstacles.reach > 0)), np.array([x_0, z_0]), np.array([x_1, z_1]))


def _on_mesh(session: Session, floor: Floor, point: np.ndarray, allowed_m: float) -> np.ndarray:
    """Return the point (2,) of the navigation mesh for `point` (3,). Refused if the mesh has none near it."""
    found = floor.nearest(point[[0, 2]], min(max(SNAP_M, allowed_m), MAX_SNAP_M))
    if found is None:
        where = Vector3(float(point[0]), float(session.world.plan.floor_y), float(point[2]))
        raise Refused(f"No point on NavMesh near {where.text(3)}.")
    return found


def _path(session: Session, start: np.ndarray, target: np.ndarray, allowed_m: float) -> dict[str, Any]:
    """Return the path from `start` to `target` (3,) as AI2-THOR's NavMeshPath. Refused if the mesh has none."""
    floor, height = _floor(session), float(session.world.plan.floor_y)

    def text(point: np.ndarray) -> str:
        return Vector3(float(point[0]), height, float(point[-1])).text(3)

    ends = [_on_mesh(session, floor, point, allowed_m) for point in (start, target)]
    if all(np.linalg.norm(end - point[[0, 2]]) > allowed_m for end, point in zip(ends, (start, target), strict=True)):
        raise Refused(
            f"Closest point on NavMesh was too far from the agent:  (startPosition={text(start)}, closest navmesh position"
            f" {text(ends[0])}) and (targetPosition={text(target)}, closest navmesh position {text(ends[1])})."
        )
    corners = shortest(floor, *ends)
    if corners is None:
        raise Refused(f"Could not find path between {text(ends[0])} and {text(ends[1])} using the NavMesh.")
    return {"corners": [Vector3(float(x), height, float(z)).to_json() for x, z in corners], "status": "PathComplete"}


def _nearest_first(session: Session, start: np.ndarray) -> Iterator[np.ndarray]:
    """Positions (3,) that moves reach from `start` (3,), in the order of the number of moves."""
    world, step = session.world, max(session.settings.grid_m, MIN_STEP_M)
    x_0, z_0, x_1, z_1 = world.room.rectangle
    here, low, high = start[[0, 2]], np.array([x_0, z_0]), np.array([x_1, z_1])
    found = reachable(world.obstacles()[0], here, low, high, step, np.eye(2))
    at = {(int(i), int(j)): p for (i, j), p in zip(np.round((found - here) / step), found, strict=True)}
    queue = deque([(0, 0)])
    left = set(at) - {(0, 0)}
    while queue:
        i, j = queue.popleft()
        x, z = at[i, j]
        yield np.array([x, start[1], z])
        for cell in ((i + 1, j), (i, j + 1), (i - 1, j), (i, j - 1)):
            if cell in left:
                left.remove(cell)
                queue.append(cell)


def _seeing(session: Session, object_id: str, start: np.ndarray) -> np.ndarray:
    """Return the first position (3,) from which an agent that faces the object can interact with it.

    Positions are in the order of `_nearest_first`.
    """
    world, s, sight = session.world, session.settings, session.sight
    pivot = world.bodies[object_id].pose.position
    for position in islice(_nearest_first(session, start), MAX_VIEWPOINTS):
        agent = replace(world.agent, position=position)
        ways = reaching(sight, object_id, agent, s.visibility_m)
        if len(ways) and in_picture(ways, _facing(agent, pivot), s.field_of_view_deg, session.width / session.height).any():
            return position
    raise Refused(
        f"Target object {object_id} is not visible on navigation path given current agent parameters:"
        f" maxVisibleDistance ({s.visibility_m:g}), gridSize ({s.grid_m:g}), fieldOfView ({s.field_of_view_deg:g}),"
        f" camera height ({world.agent.camera[1]:g}), visibilityScheme ({s.visibility_scheme})."
    )


def _facing(agent: Agent, point: np.ndarray) -> np.ndarray:
    x, y, z = point - agent.camera
    return axes(math.degrees(math.atan2(x, z)), -math.degrees(math.atan2(y, math.hypot(x, z))))


def _start(session: Session, position: Vector3 | None, allowed_m: float) -> np.ndarray:
    """Start (3,) of a path, at the height of the agent whatever height was given."""
    if allowed_m < 0:
        raise Refused(f"allowedError must not be negative. You gave {allowed_m:g}.")
    here = session.world.agent.position
    return here.copy() if position is None else np.array([position.x, here[1], position.z])


def _to_object(
    session: Session, object_type: str | None, object_id: str | None, start: np.ndarray, allowed_m: float
) -> dict[str, Any]:
    target = _of_type_or_id(session, object_type, object_id)
    _on_mesh(session, _floor(session), start, allowed_m)
    return _path(session, start, _seeing(session, target, start), allowed_m)


@action("GetShortestPath")
def shortest_path_from_pose(
    session: Session,
    position: Vector3,
    rotation: Vector3,
    objectType: str | None = None,
    objectId: str | None = None,
    allowedError: float = ERROR_M,
) -> dict[str, Any]:
    """GetShortestPath from a pose; the rotation is not used."""
    return _to_object(session, objectType, objectId, _start(session, position, allowedError), allowedError)


@action("GetShortestPath")
def shortest_path_from_position(
    session: Session,
    position: Vector3,
    objectType: str | None = None,
    objectId: str | None = None,
    allowedError: float = ERROR_M,
) -> dict[str, Any]:
    """GetShortestPath from a position."""
    return _to_object(session, objectType, objectId, _start(session, position, allowedError), allowedError)


@action("GetShortestPath")
def shortest_path(
    session: Session, objectType: str | None = None, objectId: str | None = None, allowedError: float = ERROR_M
) -> dict[str, Any]:
    """GetShortestPath from the agent."""
    return _to_object(session, objectType, objectId, _start(session, None, allowedError), allowedError)


@action("GetShortestPathToPoint")
def shortest_path_to_point_from_position(
    session: Session, position: Vector3, x: float, y: float, z: float, allowedError: float = ERROR_M
) -> dict[str, Any]:
    """GetShortestPathToPoint from a position."""
    return _path(session, _start(session, position, allowedError), np.array([x, y, z]), allowedError)


@action("GetShortestPathToPoint")
def shortest_path_to_point(session: Session, x: float, y: float, z: float, allowedError: float = ERROR_M) -> dict[str, Any]:
    """GetShortestPathToPoint from the agent."""
    return _path(session, _start(session, None, allowedError), np.array([x, y, z]), allowedError)


@action("ObjectTypeToObjectIds")
def object_ids_of_type(session: Session, objectType: str | None) -> list[str]:
    """ObjectTypeToObjectIds: the objectIds of all objects of a type, an empty list if the scene has none."""
    if objectType is None:
        raise null_reference()
    wanted = objectType.replace(" ", "").lower()
    return [b.object_id for b in session.world.bodies.values() if not b.removed and b.obj.type.lower() == wanted]
