"""Points and poses. Unity's world frame: left-handed, y up, metres; yaw 0 looks along +z, 90 along +x."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator

from ovman.records.record import Record


def _point(value: Any) -> tuple[float, float]:
    if isinstance(value, dict):
        missing = [axis for axis in ("x", "z") if axis not in value]
        if missing:
            raise ValueError(f"{missing[0]}: the key is missing")
        value = (value["x"], value["z"])
    if not isinstance(value, tuple) or len(value) != 2:
        raise ValueError("expected a point; write {x, z} in metres")
    for axis, number in zip("xz", value, strict=True):
        if isinstance(number, bool) or not isinstance(number, int | float) or not math.isfinite(number):
            raise ValueError(f"{axis}: expected a number, found {number!r}")
    return float(value[0]), float(value[1])


Point = Annotated[
    tuple[float, float], PlainValidator(_point), PlainSerializer(lambda point: {"x": float(point[0]), "z": float(point[1])})
]
"""Floor-plane position (x, z) in metres; in files {"x", "z"}."""


class Position(Record):
    """A position in the room, metres."""

    x: float
    y: float
    z: float


def floor_point(position: Position | None) -> Point | None:
    """Return a position's point on the floor plane, None for None."""
    return None if position is None else (position.x, position.z)


class Spawn(Record):
    """A pose of the agent's base: floor plane in metres, yaw in degrees."""

    x: float
    z: float
    yaw_deg: float
