"""Actions that put objects somewhere, hide them or take them away."""

from __future__ import annotations

from typing import Any

import numpy as np

from ovman_engine.actions.registry import Thrown, action
from ovman_engine.actions.values import ObjectPose, Vector3
from ovman_engine.engine import Engine
from ovman_engine.plan.floorplan import rotation_matrix
from ovman_engine.world.world import Refused, Unsettled


def _turned(rotation: Vector3 | None) -> np.ndarray | None:
    return None if rotation is None else rotation_matrix(rotation.array)


@action("PlaceObjectAtPoint")
def place_object_at_point(
    engine: Engine, objectId: str, position: Vector3, rotation: Vector3 | None = None, forceKinematic: bool = False
) -> dict[str, float]:
    rested = engine.world.place(objectId, position.array, _turned(rotation), forceKinematic, settle=engine.auto_simulation)
    return Vector3.of(rested).to_json()


@action("PlaceObjectAtPoint")
def place_object_at_first_free_point(
    engine: Engine, objectId: str, positions: list[Vector3], rotation: Vector3 | None = None, forceKinematic: bool = False
) -> dict[str, float]:
    refusal = Refused("")
    for position in positions:
        try:
            return place_object_at_point(engine, objectId, position, rotation, forceKinematic)
        except Unsettled:
            raise
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
    allowTeleportOutOfHand: bool = False,
    makeUnbreakable: bool = False,
) -> None:
    """Nothing is held or breaks."""
    engine.world.teleport(objectId, position.array, _turned(rotation), forceAction, forceKinematic)


@action("TeleportObject")
def teleport_object_to_coordinates(
    engine: Engine,
    objectId: str,
    x: float,
    y: float,
    z: float,
    rotation: Vector3 | None = None,
    forceAction: bool = False,
    forceKinematic: bool = False,
    allowTeleportOutOfHand: bool = False,
    makeUnbreakable: bool = False,
) -> None:
    teleport_object(engine, objectId, Vector3(x, y, z), rotation, forceAction, forceKinematic)


@action("TeleportObject")
def teleport_object_to_first_free_point(
    engine: Engine,
    objectId: str,
    positions: list[Vector3],
    rotation: Vector3 | None = None,
    forceAction: bool = False,
    forceKinematic: bool = False,
    allowTeleportOutOfHand: bool = False,
    makeUnbreakable: bool = False,
) -> None:
    refusal = Refused("")
    for position in positions:
        try:
            return teleport_object(engine, objectId, position, rotation, forceAction, forceKinematic)
        except Refused as error:
            refusal = error
    raise refusal


@action("SetObjectPoses")
def set_object_poses(
    engine: Engine, objectPoses: list[ObjectPose] | None = None, placeStationary: bool = True, **rest: Any
) -> str:
    if objectPoses is None:
        raise Refused(
            "objectPoses was not initialized correctly. Please make sure each element in the objectPoses list is initialized."
        )
    if not objectPoses:
        raise Thrown("IndexOutOfRangeException", "Index was outside the bounds of the array.")
    poses = [
        {"objectName": p.objectName, "position": p.position.array, "rotation": rotation_matrix(p.rotation.array)}
        for p in objectPoses
    ]
    engine.world.set_poses(poses, placeStationary)
    return ""


@action("DisableObject")
def disable_object(engine: Engine, objectId: str) -> None:
    engine.world.set_active(objectId, False)


@action("EnableObject")
def enable_object(engine: Engine, objectId: str) -> None:
    engine.world.set_active(objectId, True)


@action("RemoveFromScene")
def remove_from_scene(engine: Engine, objectId: str) -> None:
    engine.world.remove(objectId)


@action("RemoveFromScene")
def remove_all_from_scene(engine: Engine, objectIds: list[str]) -> None:
    if not objectIds:
        raise Refused("objectIds must not be empty!")
    engine.world.remove(*objectIds)


@action("RemoveObjsFromScene")
def remove_objects_from_scene(engine: Engine, objectIds: list[str]) -> None:
    remove_all_from_scene(engine, objectIds)
