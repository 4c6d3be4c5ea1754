"""Converts a house to a floor plan: objects, floors, doors and windows as AI2-THOR would report them, and the agent's start.

Parts of assets in AI2-THOR (the drawers of a dresser) are missing: the asset database does not list them.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import numpy as np

from ovman_engine.plan.floorplan import Box, FloorPlan, SimObject, euler_degrees, rotation_matrix
from ovman_engine.plan.house import Furnishing, House, HouseRoom, Opening, WallSide, side
from ovman_engine.plan.vector import vector

FLOOR_M = 0.1
"""Thickness of a floor."""
FRAME_M = 0.12
"""Thickness of doors and windows, which stand out on both sides of their wall."""
STANDING_M = 0.9009992
"""Height of the agent's position above the floor."""
LATTICE_M = 0.25
PROPERTIES = {
    "toggleable": "CanToggleOnOff",
    "breakable": "CanBreak",
    "canFillWithLiquid": "CanBeFilled",
    "dirtyable": "CanBeDirty",
    "canBeUsedUp": "CanBeUsedUp",
    "cookable": "CanBeCooked",
    "isHeatSource": "isHeatSource",
    "isColdSource": "isColdSource",
    "sliceable": "CanBeSliced",
    "openable": "CanOpen",
}
"""Key of an object's metadata -> asset property."""
STATES = ("isToggled", "isBroken", "isFilledWithLiquid", "isDirty", "isUsedUp", "isCooked", "isSliced", "isOpen", "isPickedUp")


def plan_of(house: House) -> FloorPlan:
    """Return the floor plan of `house`. It keeps the house for its walls."""
    objects = [_floor(room) for room in house.rooms]
    walls = {w.name: w for w in house.walls}
    objects += [_opening(o, walls[o.walls[0]], house) for o in house.openings]
    objects += _furnished(house)
    return FloorPlan(house.name, "house", tuple(objects), _start(house, objects), 0.0, house)


def hole(opening: Opening, wall: WallSide) -> tuple[np.ndarray, np.ndarray]:
    """Opposite corners (3,) of an opening in its first wall, world frame, metres."""
    ends = (wall.start + wall.along * at for at in (opening.low[0], opening.high[0]))
    low, high = ((x, wall.bottom + y, z) for (x, z), y in zip(ends, (opening.low[1], opening.high[1]), strict=True))
    return np.array(low), np.array(high)


def _object(name: str, kind: str, asset_id: str, box: Box, properties: frozenset[str] = frozenset(), **own: Any) -> SimObject:
    """Return an object of the house, with its record in AI2-THOR's form."""
    low, high = box.bounds()
    pickupable, moveable = own.pop("pickupable", False), own.pop("moveable", False)
    openness, mass, parents = own.pop("openness", 0.0), own.pop("mass", 0.0), own.pop("parents", ())
    corners = [[float(x), float(y), float(z)] for x in (high[0], low[0]) for y in (high[1], low[1]) for z in (high[2], low[2])]
    record = {
        "objectId": name,
        "name": name,
        "objectType": kind,
        "assetId": asset_id,
        "position": vector(*box.centre),
        "rotation": vector(*euler_degrees(box.rotation)),
        "axisAlignedBoundingBox": {"cornerPoints": corners, "center": vector(*(low + high) / 2), "size": vector(*(high - low))},
        "objectOrientedBoundingBox": {"cornerPoints": box.corners().tolist()} if pickupable or moveable else None,
        "pickupable": pickupable,
        "moveable": moveable,
        "mass": mass,
        "receptacle": "Receptacle" in properties,
        "parentReceptacles": list(parents) or None,
        "receptacleObjectIds": [] if "Receptacle" in properties else None,
        "salientMaterials": [] if pickupable or moveable else None,
        "controlledObjects": None,
        "fillLiquid": None,
        "temperature": "RoomTemp",
        "distance": 0.0,
        "visible": False,
        "isInteractable": False,
        "isMoving": False,
        "openness": openness,
        **{key: source in properties for key, source in PROPERTIES.items()},
        **dict.fromkeys(STATES, False),
    }
    record["isOpen"] = record["openable"] and openness > 0
    return SimObject(
        name, name, kind, asset_id, box.centre, box.rotation, box, moveable, pickupable, mass, tuple(parents),
        MappingProxyType(record),
    )  # fmt: skip


def _floor(room: HouseRoom) -> SimObject:
    low, high = room.polygon.min(axis=0), room.polygon.max(axis=0)
    centre, half = (low + high) / 2, (high - low) / 2
    box = Box(np.array([centre[0], -FLOOR_M / 2, centre[1]]), np.array([half[0], FLOOR_M / 2, half[1]]), np.eye(3))
    return _object(room.name, "Floor", room.floor_material, box, frozenset(["Receptacle"]))


def _opening(opening: Opening, wall: WallSide, house: House) -> SimObject:
    """Return a door or a window that faces the room of its first wall."""
    low, high = hole(opening, wall)
    x, z = wall.along * side(wall, house)
    turn = np.array([[x, 0.0, -z], [0.0, 1.0, 0.0], [z, 0.0, x]])
    half = np.array([opening.high[0] - opening.low[0], opening.high[1] - opening.low[1], FRAME_M]) / 2
    kind = "Window" if opening.window else opening.asset_id.split("_")[0]
    kind = kind if kind in ("Window", "Doorway", "Doorframe") else "Doorway"
    properties = frozenset(["CanOpen"] if opening.openable else [])
    return _object(opening.name, kind, opening.asset_id, Box((low + high) / 2, half, turn), properties, openness=opening.openness)


def _furnished(house: House) -> list[SimObject]:
    out = []
    held: dict[str, list[str]] = {}
    for thing in house.objects:
        parents = _parents(thing, house)
        for parent in parents:
            held.setdefault(parent, []).append(thing.name)
        out.append(_thing(thing, parents))
    for obj in out:
        if obj.record["receptacle"]:
            obj.record["receptacleObjectIds"].extend(held.get(obj.object_id, []))
    return out


def _thing(thing: Furnishing, parents: tuple[str, ...]) -> SimObject:
    made = thing.asset
    return _object(
        thing.name,
        made.type,
        made.asset_id,
        Box(thing.position, made.size / 2, rotation_matrix(thing.rotation)),
        made.properties,
        pickupable=made.pickupable,
        moveable=made.moveable,
        mass=made.mass,
        openness=thing.openness,
        parents=parents,
    )


def _parents(thing: Furnishing, house: House) -> tuple[str, ...]:
    if thing.parent is not None:
        return (thing.parent,)
    if thing.position[1] - thing.asset.size[1] / 2 > FLOOR_M:
        return ()
    return tuple(room.name for room in house.rooms if room.contains(thing.position[[0, 2]]))


def _start(house: House, objects: list[SimObject]) -> np.ndarray:
    """Return the agent's start (3,): as the house gives it, else the lattice point that is farthest from walls and objects."""
    if house.agent is not None:
        return np.array([house.agent[0][0], STANDING_M, house.agent[0][2]])
    polygons = np.concatenate([room.polygon for room in house.rooms])
    axes = [np.arange(np.ceil(a / LATTICE_M), np.floor(b / LATTICE_M) + 1) * LATTICE_M
            for a, b in zip(polygons.min(axis=0), polygons.max(axis=0), strict=True)]  # fmt: skip
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    points = points[np.any([room.contains(points) for room in house.rooms], axis=0)]
    if not len(points):
        return np.array([*polygons.mean(axis=0)]).dot([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) + [0.0, STANDING_M, 0.0]
    clear = np.full(len(points), np.inf)
    for obj in objects:
        if obj.type != "Floor":
            low, high = (corner[[0, 2]] for corner in obj.box.bounds())
            clear = np.minimum(clear, np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=1))
    for wall in house.walls:
        along = np.clip((points - wall.start) @ wall.along, 0.0, wall.length)
        clear = np.minimum(clear, np.linalg.norm(points - wall.start - along[:, None] * wall.along, axis=1))
    x, z = points[int(np.argmax(clear))]
    return np.array([x, STANDING_M, z])
