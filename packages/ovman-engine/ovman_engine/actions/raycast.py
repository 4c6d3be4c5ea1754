"""The object or the point behind a pixel of the agent's image, and the bounds of the scene. Nothing changes.

Source: AI2-THOR's BaseFPSAgentController (GetObjectInFrame, GetCoordinateFromRaycast, GetSceneBounds).
"""

from __future__ import annotations

import math

import numpy as np

from ovman_engine.actions.registry import action, out_of_range
from ovman_engine.actions.values import Vector3
from ovman_engine.client.session import Session
from ovman_engine.sight.visibility import Eye, axes
from ovman_engine.world.errors import Refused


def _met(session: Session, x: float, y: float) -> tuple[str | None, np.ndarray]:
    """Return the first instance on the ray through a point of the image, and where the ray meets it, (3,) metres.

    The point is given as fractions of the image's width and height, from the top left. Without a hit the name is None, and the
    point lies at the distance of the far plane.
    """
    agent, s = session.world.agent, session.settings
    tall = math.tan(math.radians(s.field_of_view_deg) / 2)
    right, up, forward = axes(agent.yaw_deg, agent.horizon_deg)
    way = right * (2 * x - 1) * tall * session.width / session.height + up * (1 - 2 * y) * tall + forward
    way /= np.linalg.norm(way)
    lines = session.sight.lines
    owner, distance = lines.first(agent.camera[None], way[None], np.zeros(len(lines.names), dtype=bool))
    if owner[0] < 0:
        return None, agent.camera + way * s.far_m
    return lines.names[owner[0]], agent.camera + way * float(distance[0])


def _interactable(session: Session) -> set[str]:
    s = session.settings
    eye = Eye.of(session.world.agent, s.field_of_view_deg, session.width / session.height)
    return session.sight.visible(eye, s.visibility_m, s.visibility_scheme)[1]


@action("GetObjectInFrame")
def object_in_frame(session: Session, x: float, y: float, checkVisible: bool = False) -> str:
    """GetObjectInFrame: the objectId behind a point of the image. Refused if the ray meets no object."""
    if not (0 <= x <= 1 and 0 <= y <= 1):
        raise out_of_range("x/y must be in [0:1]")
    name, _ = _met(session, x, y)
    if name is None or name not in session.world.bodies:
        raise Refused(f"no sim objects found at ({x:g},{y:g})")
    if checkVisible and name not in _interactable(session):
        raise Refused(f"target hit ({name}) at ({x:g}, {y:g}) is not currently Visible to Agent")
    return name


@action("GetCoordinateFromRaycast")
def coordinate_from_raycast(session: Session, x: float, y: float) -> dict[str, float]:
    """GetCoordinateFromRaycast: where the ray through a point of the image meets the scene, metres."""
    if not (0 <= x <= 1 and 0 <= y <= 1):
        raise out_of_range(f"x and y must be in [0:1] not (x={x:g}, y={y:g}).")
    return Vector3.of(_met(session, x, y)[1]).to_json()


@action("GetSceneBounds")
def scene_bounds(session: Session) -> list[dict[str, float]]:
    """GetSceneBounds: lower and upper corner of the scene, metres."""
    return [Vector3.of(corner).to_json() for corner in session.world.bounds()]
