"""Actions that place, hide, show and remove objects."""

from __future__ import annotations

from typing import Any

import numpy as np

from ovman_engine.actions.registry import Thrown, action
from ovman_engine.actions.values import ObjectPose, Vector3
from ovman_engine.client.session import Session
from ovman_engine.plan.floorplan import rotation_matrix
from ovman_engine.world.errors import Refused, Unsettled


def _turned(rotation: Vector3 | None) -> np.ndarray | None:
    return None if rotation is None else rotation_matrix(rotation.array)


@action("PlaceObjectAtPoint")
def place_object_at_point(
    session: Session, objectId: str, position: Vector3, rotation: Vector3 | None = None, forceKinematic: bool = False
) -> dict[str, float]:
    """PlaceObjectAtPoint: puts an object on the surface below a point. Returns where its pivot comes to rest, metres."""
    rested = session.world.place(objectId, position.array, _turned(rotation), forceKinematic, settle=session.auto_simulation)
    return Vector3.of(rested).to_json()


@action("PlaceObjectAtPoint")
def place_object_at_first_free_point(
    session: Session, objectId: str, positions: list[Vector3], rotation: Vector3 | None = None, forceKinematic: bool = False
) -> dict[str, float]:
    """PlaceObjectAtPoint at the first of several points that is free."""
    refusal = Refused("")
    for position in positions:
        try:
            return place_object_at_point(session, objectId, position, rotation, forceKinematic)
        except Unsettled:
            raise
        except Refused as error:
            refusal = error
    raise refusal


@action("TeleportObject")
def teleport_object(
    session: Session,
    objectId: str,
    position: Vector3,
    rotation: Vector3 | None = None,
    forceAction: bool = False,
    forceKinematic: bool = False,
    allowTeleportOutOfHand: bool = False,
    makeUnbreakable: bool = False,
) -> None:
    """TeleportObject: puts an object exactly at a pose. The last two arguments have no effect: nothing is held or breaks."""
    session.world.teleport(objectId, position.array, _turned(rotation), forceAction, forceKinematic)


@action("TeleportObject")
def teleport_object_to_coordinates(
    session: Session,
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
    """TeleportObject with x, y and z in place of a position."""
    teleport_object(session, objectId, Vector3(x, y, z), rotation, forceAction, forceKinematic)


@action("TeleportObject")
def teleport_object_to_first_free_point(
    session: Session,
    objectId: str,
    positions: list[Vector3],
    rotation: Vector3 | None = None,
    forceAction: bool = False,
    forceKinematic: bool = False,
    allowTeleportOutOfHand: bool = False,
    makeUnbreakable: bool = False,
) -> None:
    """TeleportObject to the first of several positions that is free."""
    refusal = Refused("")
    for position in positions:
        try:
            return teleport_object(session, objectId, position, rotation, forceAction, forceKinematic)
        except Refused as error:
            refusal = error
    raise refusal


@action("SetObjectPoses")
def set_object_poses(
    session: Session,
    objectPoses: list[ObjectPose] | None = None,
    placeStationary: bool = True,
    enablePhysicsJitter: bool = False,
    forceRigidbodySleep: bool = False,
    skipMoveable: bool = False,
    **rest: Any,
) -> str:
    """SetObjectPoses: arranges the movable objects as listed, and removes all others.

    With `skipMoveable`, objects that are moveable but not pickupable stay as they are. With `forceRigidbodySleep`, the listed
    objects stay where they are put until something wakes them. `enablePhysicsJitter` has no effect.
    """
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
    session.world.set_poses(poses, placeStationary, asleep=forceRigidbodySleep, skip_moveable=skipMoveable)
    return ""


@action("DisableObject")
def disable_object(session: Session, objectId: str) -> None:
    """DisableObject: makes an object invisible and without collisions."""
    session.world.set_active(objectId, False)


@action("EnableObject")
def enable_object(session: Session, objectId: str) -> None:
    """EnableObject: undoes DisableObject."""
    session.world.set_active(objectId, True)


@action("RemoveFromScene")
def remove_from_scene(session: Session, objectId: str) -> None:
    """RemoveFromScene of one object."""
    session.world.remove(objectId)


@action("RemoveFromScene")
def remove_all_from_scene(session: Session, objectIds: list[str]) -> None:
    """RemoveFromScene of several objects."""
    if not objectIds:
        raise Refused("objectIds must not be empty!")
    session.world.remove(*objectIds)


@action("RemoveObjsFromScene")
def remove_objects_from_scene(session: Session, objectIds: list[str]) -> None:
    """RemoveObjsFromScene: the former name of RemoveFromScene for several objects."""
    remove_all_from_scene(session, objectIds)
