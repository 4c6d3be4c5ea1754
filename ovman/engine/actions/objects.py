"""Actions that put objects somewhere, hide them or take them away."""

from __future__ import annotations

from typing import Any

import numpy as np

from ovman.engine.actions.registry import action
from ovman.engine.actions.values import ObjectPose, Vector3
from ovman.engine.engine import Engine
from ovman.engine.floorplan import rotation_matrix
from ovman.engine.world import Refused


def _turned(rotation: Vector3 | None) -> np.ndarray | None:
    return None if rotation is None else rotation_matrix(rotation.array)


@action("PlaceObjectAtPoint")
def place_object_at_point(
    engine: Engine, objectId: str, position: Vector3, rotation: Vector3 | None = None, forceKinematic: bool = False
) -> dict[str, float]:
    return Vector3.of(engine.world.place(objectId, position.array, _turned(rotation), forceKinematic)).to_json()


@action("PlaceObjectAtPoint")
def place_object_at_first_free_point(
    engine: Engine, objectId: str, positions: list[Vector3], rotation: Vector3 | None = None, forceKinematic: bool = False
) -> dict[str, float]:
    refusal = Refused("PlaceObjectAtPoint needs at least one position.")
    for position in positions:
        try:
            return place_object_at_point(engine, objectId, position, rotation, forceKinematic)
        except Refused as error:
            refusal = error
    raise refusal


@action("TeleportObject")
def teleport_object(
    engine: Engine,
    objectId: str,
    position: Vector3,
    rotation: Vector3 | None = None,
    forceAction: bool = False,
    forceKinematic: bool = False,
) -> None:
    engine.world.teleport(objectId, position.array, _turned(rotation), forceAction, forceKinematic)


@action("SetObjectPoses")
def set_object_poses(engine: Engine, objectPoses: list[ObjectPose], placeStationary: bool = True, **rest: Any) -> None:
    poses = [
        {"objectName": p.objectName, "position": p.position.array, "rotation": rotation_matrix(p.rotation.array)}
        for p in objectPoses
    ]
    # AI2-THOR collects the scene's objects anew: it no longer lists what is inactive then, and finds what it had not listed.
    bodies = engine.world.bodies
    for body in bodies.values():
        body.removed &= body.active
    try:
        engine.world.set_poses(poses, placeStationary)
    finally:
        for body in bodies.values():
            body.removed |= not body.active


@action("DisableObject")
def disable_object(engine: Engine, objectId: str) -> None:
    _set_active(engine, objectId, False)


@action("EnableObject")
def enable_object(engine: Engine, objectId: str) -> None:
    _set_active(engine, objectId, True)


def _set_active(engine: Engine, object_id: str, active: bool) -> None:
    body = engine.world.bodies.get(object_id)
    if body is None or body.removed:
        raise Refused("")
    engine.world.set_active(object_id, active)


@action("RemoveFromScene")
def remove_from_scene(engine: Engine, objectId: str) -> None:
    engine.world.remove(objectId)


@action("RemoveFromScene")
def remove_all_from_scene(engine: Engine, objectIds: list[str]) -> None:
    for object_id in objectIds:
        engine.world.remove(object_id)
