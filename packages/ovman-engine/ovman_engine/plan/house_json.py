"""Reads and checks houses in JSON. An invalid house is refused with the place and the reason.

Source: the format of AI2-THOR's CreateHouse in the types of the pip package ``procthor``, and its later version, in which holes
are polygons.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ovman_engine.plan.assets import asset
from ovman_engine.plan.house import MIN_SIDE_M, Furnishing, House, HouseRoom, Opening, WallSide, rectangles

MAX_COORDINATE_M = 1000.0
"""Largest coordinate, metres."""
MAX_OBJECTS, MAX_WALLS, MAX_ROOMS, MAX_CORNERS = 2000, 1000, 100, 200
"""Largest number of objects, walls and rooms of a house, and of corners of a floor."""


class InvalidHouse(ValueError):
    """A JSON value is no valid house. The message says where and why."""


def read(given: Any) -> House:
    """Return the house that the JSON value `given` describes. Raises InvalidHouse."""
    if not isinstance(given, Mapping):
        raise InvalidHouse(f"house is a JSON object, not {str(given)[:60]!r}")
    # Light and colours follow the name, so it is that of the building: one object less must not repaint the others.
    shell = {key: given[key] for key in ("rooms", "walls", "doors", "windows", "proceduralParameters") if key in given}
    name = hashlib.blake2b(json.dumps(shell, sort_keys=True).encode(), digest_size=4).hexdigest()
    rooms = tuple(_room(r, f"rooms[{k}]") for k, r in enumerate(_list(given, "rooms", "house", MAX_ROOMS)))
    if not rooms:
        raise InvalidHouse("house.rooms is empty: a house needs a room")
    walls = tuple(_wall(w, f"walls[{k}]") for k, w in enumerate(_list(given, "walls", "house", MAX_WALLS)))
    known = {w.name for w in walls}
    openings = tuple(
        _opening(o, f"{key}[{k}]", known, key == "windows")
        for key in ("doors", "windows")
        for k, o in enumerate(_list(given, key, "house", MAX_OBJECTS))
    )
    objects: list[Furnishing] = []
    for k, o in enumerate(_list(given, "objects", "house", MAX_OBJECTS)):
        _furnish(o, f"objects[{k}]", None, objects)
    _unique([*rooms, *openings, *objects])
    metadata = given.get("metadata")
    agent = metadata.get("agent") if isinstance(metadata, Mapping) else None
    return House(f"Procedural-{name}", rooms, walls, openings, tuple(objects), None if agent is None else _agent(agent))


def _unique(named: list[Any]) -> None:
    seen: set[str] = set()
    for thing in named:
        if thing.name in seen:
            raise InvalidHouse(f"two things have the id {thing.name!r}")
        seen.add(thing.name)


def _value(given: Any, key: str, where: str) -> Any:
    if not isinstance(given, Mapping):
        raise InvalidHouse(f"house.{where} is a JSON object, not {str(given)[:60]!r}")
    if key not in given:
        raise InvalidHouse(f"house.{where} has no {key!r}")
    return given[key]


def _list(given: Any, key: str, where: str, most: int) -> list[Any]:
    found = given.get(key) if isinstance(given, Mapping) else None
    if found is None:
        return []
    if not isinstance(found, list):
        raise InvalidHouse(f"{where}.{key} is a list, not {str(found)[:60]!r}")
    if len(found) > most:
        raise InvalidHouse(f"{where}.{key} has {len(found)} entries; at most {most} are possible")
    return found


def _text(given: Any, key: str, where: str) -> str:
    found = _value(given, key, where)
    if not isinstance(found, str) or not found:
        raise InvalidHouse(f"house.{where}.{key} is a text, not {str(found)[:60]!r}")
    return found


def _number(given: Any, where: str) -> float:
    if isinstance(given, bool) or not isinstance(given, int | float) or not math.isfinite(given) or abs(given) > MAX_COORDINATE_M:
        raise InvalidHouse(f"house.{where} is a number within {MAX_COORDINATE_M:g}, not {str(given)[:60]!r}")
    return float(given)


def _vector(given: Any, where: str, axes: str = "xyz") -> np.ndarray:
    return np.array([_number(_value(given, axis, where), f"{where}.{axis}") for axis in axes])


def _material(given: Any) -> tuple[str, tuple[float, float, float] | None]:
    """Name of a material, and its colour if given, from a text or from {name, color}."""
    if isinstance(given, Mapping):
        colour = given.get("color")
        tone = None
        if isinstance(colour, Mapping):
            red, green, blue = np.clip(_vector(colour, "color", "rgb"), 0.0, 1.0).tolist()
            tone = red, green, blue
        return str(given.get("name", "")), tone
    return (given if isinstance(given, str) else ""), None


def _room(given: Any, where: str) -> HouseRoom:
    points = _value(given, "floorPolygon", where)
    if not isinstance(points, list) or len(points) < 3:
        raise InvalidHouse(f"house.{where}.floorPolygon is a list of at least three points")
    if len(points) > MAX_CORNERS:
        raise InvalidHouse(f"house.{where}.floorPolygon has {len(points)} points; at most {MAX_CORNERS} are possible")
    polygon = np.array([_vector(p, f"{where}.floorPolygon[{k}]", "xz") for k, p in enumerate(points)])
    x, z = polygon.T
    if abs(float(x @ np.roll(z, -1) - z @ np.roll(x, -1))) < 0.02:
        raise InvalidHouse(f"house.{where}.floorPolygon encloses nothing")
    room = HouseRoom(_text(given, "id", where), str(given.get("roomType", "")), polygon, _material(given.get("floorMaterial"))[0])
    if not rectangles(room):
        raise InvalidHouse(f"house.{where}.floorPolygon encloses no floor: it covers itself, or is at most {MIN_SIDE_M:g} m wide")
    return room


def _wall(given: Any, where: str) -> WallSide:
    points = _value(given, "polygon", where)
    if not isinstance(points, list) or len(points) < 3:
        raise InvalidHouse(f"house.{where}.polygon is a list of at least three points")
    corners = np.array([_vector(p, f"{where}.polygon[{k}]") for k, p in enumerate(points)])
    start, end = corners[np.argsort(corners[:, 1], kind="stable")[:2]][:, [0, 2]]
    if np.linalg.norm(end - start) < 1e-3 or np.ptp(corners[:, 1]) < 1e-3:
        raise InvalidHouse(f"house.{where}.polygon has no area")
    paint, colour = _material(given.get("material"))
    tone = _material({"name": paint, "color": given.get("color")})[1] or colour
    low, high = corners[:, 1].min(), corners[:, 1].max()
    room = str(given.get("roomId", ""))
    return WallSide(
        _text(given, "id", where), room, start, end, float(low), float(high), paint, tone, bool(given.get("empty", False))
    )


def _opening(given: Any, where: str, walls: set[str], window: bool) -> Opening:
    beside = tuple(w for w in (given.get("wall0"), given.get("wall1")) if w) if isinstance(given, Mapping) else ()
    if not beside or not isinstance(beside[0], str) or beside[0] not in walls:
        raise InvalidHouse(f"house.{where}.wall0 is the id of none of its walls")
    if "holePolygon" in given:
        corners = given["holePolygon"]
        if not isinstance(corners, list) or len(corners) < 2:
            raise InvalidHouse(f"house.{where}.holePolygon is a list of at least two points")
        hole = np.array([_vector(p, f"{where}.holePolygon[{k}]", "xy") for k, p in enumerate(corners)])
    else:
        box = _value(given, "boundingBox", where)
        hole = np.array(
            [_vector(_value(box, end, f"{where}.boundingBox"), f"{where}.boundingBox.{end}", "xy") for end in ("min", "max")]
        )
    low, high = hole.min(axis=0), hole.max(axis=0)
    if (high - low < 0.01).any():
        raise InvalidHouse(f"house.{where} is a hole of no size")
    rooms = tuple(str(r) for r in (given.get("room0"), given.get("room1")) if r)
    openness = _number(given.get("openness") or 0, f"{where}.openness")
    asset_id = _text(given, "assetId", where)
    return Opening(
        _text(given, "id", where), asset_id, beside, rooms, low, high, bool(given.get("openable", False)), openness, window
    )


def _furnish(given: Any, where: str, parent: str | None, out: list[Furnishing]) -> None:
    name, asset_id = _text(given, "id", where), _text(given, "assetId", where)
    try:
        made = asset(asset_id)
    except KeyError:
        raise InvalidHouse(f"house.{where}.assetId: there is no asset {asset_id!r}") from None
    if len(out) >= MAX_OBJECTS:
        raise InvalidHouse(f"house.objects has more than {MAX_OBJECTS} entries")
    position = _vector(_value(given, "position", where), f"{where}.position")
    rotation = _vector(given["rotation"], f"{where}.rotation") if given.get("rotation") is not None else np.zeros(3)
    openness = _number(given.get("openness") or 0, f"{where}.openness")
    out.append(Furnishing(name, made, position, rotation, bool(given.get("kinematic", False)), openness, parent))
    for k, child in enumerate(_list(given, "children", f"house.{where}", MAX_OBJECTS)):
        _furnish(child, f"{where}.children[{k}]", name, out)


def _agent(given: Any) -> tuple[np.ndarray, float, float, bool]:
    position = _vector(_value(given, "position", "metadata.agent"), "metadata.agent.position")
    rotation = given.get("rotation") or {}
    yaw = _number(rotation.get("y", 0) if isinstance(rotation, Mapping) else rotation, "metadata.agent.rotation.y")
    horizon = _number(given.get("horizon") or 0, "metadata.agent.horizon")
    return position, yaw % 360.0, horizon, bool(given.get("standing", True))
