"""The metadata of an event, with all of AI2-THOR's keys. Imports little: the first event is sent before a scene is loaded."""

from __future__ import annotations

import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ovman_engine.client import log
from ovman_engine.plan.vector import vector

if TYPE_CHECKING:
    from ovman_engine.client.metadata import SceneMetadata
    from ovman_engine.client.session import Session

NO_BOUNDS = {"center": {"x": 0.0, "y": 0.0, "z": 0.0}, "size": {"x": 0.0, "y": 0.0, "z": 0.0}, "cornerPoints": [[0.0] * 3] * 8}


@dataclass(frozen=True)
class Outcome:
    """Result of an action. `value` is its actionReturn, `code` one of AI2-THOR's error codes."""

    value: Any = None
    success: bool = True
    message: str = ""
    code: str | None = None


def thrown(error: Exception) -> Outcome:
    """Outcome of an action in which the engine itself failed, in the form of Unity's exceptions.

    The log has the whole traceback.
    """
    log.note("".join(traceback.format_exception(error)))
    where = "".join(traceback.format_tb(error.__traceback__)[-1:]).strip()
    return Outcome(success=False, message=f"{type(error).__name__}: {error}. trace: {where}")


def message(agent: Mapping[str, Any], sequence: Any) -> dict[str, Any]:
    """Return the metadata of one agent as the body of a METADATA frame."""
    return {
        "agents": [agent],
        "thirdPartyCameras": agent["thirdPartyCameras"],
        "activeAgentId": 0,
        "sequenceId": sequence,
    }


def patch(request: Mapping[str, Any], outcome: Outcome, time_s: float) -> dict[str, Any]:
    """Body of a METADATA_PATCH frame: the keys that differ from the event before if the world is unchanged."""
    return {"agentId": 0, **_result(request, outcome), "currentTime": time_s}


def _result(request: Mapping[str, Any], outcome: Outcome) -> dict[str, Any]:
    name = request.get("action")
    return {
        "lastAction": name if isinstance(name, str) else "",
        "lastActionSuccess": outcome.success,
        "errorMessage": outcome.message,
        "errorCode": outcome.code,
        "actionReturn": outcome.value,
    }


def agent(
    session: Session,
    request: Mapping[str, Any],
    outcome: Outcome,
    scene: SceneMetadata | None,
    colours: list[dict[str, Any]] | None,
) -> dict[str, Any]:
    """Metadata of the agent and of the world around it.

    `colours` is the table of colours if the event carries segmentation images; `scene` is None before the first Reset.
    """
    nowhere = vector(0.0, 0.0, 0.0)
    if scene is None:
        state = {
            "objects": [],
            "isSceneAtRest": True,
            "agent": {
                "name": "agent",
                "position": nowhere,
                "rotation": nowhere,
                "cameraHorizon": 0.0,
                "isStanding": True,
                "inHighFrictionArea": False,
            },
            "cameraPosition": nowhere,
            "sceneBounds": NO_BOUNDS,
        }
    else:
        state = scene.state(session.settings, session.width / session.height)
        if session.map_view is not None:
            state["cameraPosition"] = vector(*session.map_view.position)
    return {
        **state,
        **_result(request, outcome),
        "sceneName": session.scene_name,
        "screenWidth": session.width,
        "screenHeight": session.height,
        "agentId": 0,
        "colors": colours,
        "colorBounds": None,
        "depthFormat": "Meters",
        "fov": session.settings.field_of_view_deg,
        "cameraOrthSize": -1.0 if session.map_view is None else session.map_view.half_m,
        "thirdPartyCameras": [camera.metadata(number) for number, camera in enumerate(session.cameras)],
        "heldObjectPose": {"position": nowhere, "rotation": nowhere, "localPosition": nowhere, "localRotation": nowhere},
        "arm": None,
        "collided": False,
        "collidedObjects": [],
        "inventoryObjects": [],
        "flatSurfacesOnGrid": [],
        "distances": [],
        "normals": [],
        "isOpenableGrid": [],
        "segmentedObjectIds": [],
        "objectIdsInBox": [],
        "actionIntReturn": 0,
        "actionFloatReturn": 0.0,
        "actionStringsReturn": [],
        "actionFloatsReturn": [],
        "actionVector3sReturn": [],
        "visibleRange": None,
        "currentTime": session.time_s,
    }
