"""Actions that find free places on receptacles, and put objects there at random."""

from __future__ import annotations

from typing import Any

from ovman_engine.actions.registry import Thrown, action
from ovman_engine.actions.values import Vector3
from ovman_engine.client.session import Session
from ovman_engine.world.errors import Refused

MAX_COPIES = 100
"""Largest number of objects of one type that a scene may be given."""


@action("GetSpawnCoordinatesAboveReceptacle")
def spawn_coordinates(session: Session, objectId: str, anywhere: bool = True) -> list[dict[str, float]]:
    """Answer GetSpawnCoordinatesAboveReceptacle (contract, section 4).

    These are points at which PlaceObjectAtPoint puts a small object on the receptacle. They lie above its surfaces, where nothing
    stands; unless `anywhere`, only those that the agent sees.
    """
    from ovman_engine.world.spawn import points, seen

    body = session.body(objectId)
    if not body.obj.record["receptacle"]:
        raise Refused(f"{objectId} is not a receptacle!")
    if not body.present:
        return []
    found = points(session.world, body)
    if not anywhere:
        found = found[seen(session.world, session.view(), found)]
    return [Vector3.of(p).to_json() for p in found]


@action("InitialRandomSpawn")
def initial_random_spawn(
    session: Session,
    randomSeed: int = 0,
    forceVisible: bool = False,
    placeStationary: bool = True,
    numDuplicatesOfType: list[Any] | None = None,
    excludedReceptacles: list[str] | None = None,
    excludedObjectIds: list[str] | None = None,
    objectIds: list[str] | None = None,
    receptacleObjectIds: list[str] | None = None,
    numPlacementAttempts: int = 5,
    allowFloor: bool = False,
    allowMoveable: bool = False,
) -> None:
    """InitialRandomSpawn (contract, section 4). Objects for which no place is found stay where they are."""
    from ovman_engine.shapes import FORMS, LOOSE
    from ovman_engine.world.spawn import SETTLED_S, SpawnOptions, spawn

    if numPlacementAttempts <= 0:
        raise Refused("numPlacementAttempts must be a positive integer.")
    types = {*FORMS, *LOOSE, "Floor"}
    for kind in excludedReceptacles or ():
        if kind not in types:
            raise Refused(f"invalid Object Type used in excludedReceptacles array: {kind}")
    for names in (excludedObjectIds, objectIds, receptacleObjectIds):
        for name in names or ():
            session.body(name)
    wishes = SpawnOptions(
        seed=randomSeed,
        only_outside=forceVisible,
        stationary=placeStationary,
        attempts=numPlacementAttempts,
        no_receptacles=frozenset([*(excludedReceptacles or ()), *(() if allowFloor else ("Floor",))]),
        no_objects=frozenset(excludedObjectIds or ()),
        objects=None if objectIds is None else frozenset(objectIds),
        receptacles=None if receptacleObjectIds is None else frozenset(receptacleObjectIds),
        counts=dict(_count(wish, types) for wish in numDuplicatesOfType or ()),
        moveable=allowMoveable,
    )
    spawn(session.world, wishes)
    if not placeStationary or not session.world.at_rest:
        session.world.advance(SETTLED_S)


def _count(wish: Any, types: set[str]) -> tuple[str, int]:
    """(type, number) of an entry of numDuplicatesOfType."""
    if not isinstance(wish, dict) or not isinstance(wish.get("objectType"), str) or not isinstance(wish.get("count"), int):
        raise Refused('numDuplicatesOfType takes entries like {"objectType": "Apple", "count": 3}.')
    kind, count = wish["objectType"], wish["count"]
    if kind not in types:
        raise Thrown("ArgumentException", f"Requested value '{kind}' was not found.")
    if not 0 <= count <= MAX_COPIES:
        raise Refused(f"count must be within 0 and {MAX_COPIES}, not {count}.")
    return kind, count
