"""Converts arguments from JSON to the types of an action's signature.

The conversions are those of AI2-THOR's dispatcher: numbers and texts are exchangeable where the text is a number.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, get_args, get_origin

import numpy as np

MAX_COMPONENT = 1e6
"""Largest component of a vector, metres or degrees: beyond it, sums of lengths lose their millimetres."""


class Inconvertible(ValueError):
    """A value does not convert to a plain type; AI2-THOR reports these with the code InvalidArgument."""


class Malformed(ValueError):
    """A value does not convert to a vector or a list; AI2-THOR reports these without a code."""


@dataclass(frozen=True)
class Vector3:
    """A position in metres or Euler angles in degrees; components that are not given are 0."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    @property
    def array(self) -> np.ndarray:
        """The components as an array (3,)."""
        return np.array([self.x, self.y, self.z])

    def text(self, digits: int) -> str:
        """Return the vector as Unity writes it, e.g. (1.00, 0.90, -2.00)."""
        return f"({self.x:.{digits}f}, {self.y:.{digits}f}, {self.z:.{digits}f})"

    @staticmethod
    def of(array: Any) -> Vector3:
        """Return a vector of the components of `array` (3,)."""
        return Vector3(*(float(v) for v in array))

    def to_json(self) -> dict[str, float]:
        """Return the vector as AI2-THOR's metadata write it."""
        return {"x": self.x, "y": self.y, "z": self.z}


@dataclass(frozen=True)
class PartialVector3:
    """A vector with optional components."""

    x: float | None = None
    y: float | None = None
    z: float | None = None

    def over(self, base: Sequence[float]) -> np.ndarray:
        """Return `base` (3,) with the given components replaced."""
        given = (self.x, self.y, self.z)
        return np.array([old if new is None else new for old, new in zip(base, given, strict=True)], dtype=float)


@dataclass(frozen=True)
class ObjectPose:
    """One entry of SetObjectPoses: an object's name and pose."""

    objectName: str
    position: Vector3
    rotation: Vector3


NAMES = {float: "float", int: "int", bool: "Boolean", str: "String", Vector3: "Vector3", PartialVector3: "OptionalVector3"}
"""Names of types in messages."""
CLR_NAMES = {float: "Single", int: "Int32", bool: "Boolean", str: "String", Vector3: "Vector3", PartialVector3: "OptionalVector3"}
"""Names of types in the signatures of messages."""


def shown(value: Any) -> str:
    """Return a JSON value as text for messages."""
    if isinstance(value, str):
        return value
    if value is None or isinstance(value, bool):
        return {None: "", True: "True", False: "False"}[value]
    return json.dumps(value, indent=2)


def converted(value: Any, kind: Any) -> Any:
    """`value` as a `kind`: float, int, bool, str, Vector3, ObjectPose, list[...] or Any.

    Raises Inconvertible or Malformed. Numbers must be finite: a world that contains NaN has no next state.
    """
    if kind is Any:
        return value
    if get_origin(kind) is list:
        if not isinstance(value, list):
            raise Malformed(f"Error converting value {shown(value)} to a list")
        try:
            return [converted(v, get_args(kind)[0]) for v in value]
        except Inconvertible as error:
            raise Malformed(str(error)) from None
    return _PLAIN[kind](value)


def _number(value: Any) -> float:
    if not isinstance(value, bool | int | float | str):
        raise Inconvertible(shown(value))
    try:
        number = float(value)
    except (ValueError, OverflowError):
        raise Inconvertible(shown(value)) from None
    if not math.isfinite(number):
        raise Inconvertible(shown(value))
    return number


def _integer(value: Any) -> int:
    number = round(_number(value))
    if not -(2**31) <= number < 2**31:
        raise Inconvertible(shown(value))
    return number


def _truth(value: Any) -> bool:
    if isinstance(value, bool):
        return value
    if isinstance(value, int | float):
        return value != 0
    if isinstance(value, str) and value.strip().lower() in ("true", "false"):
        return value.strip().lower() == "true"
    raise Inconvertible(shown(value))


def _text(value: Any) -> str:
    if isinstance(value, bool | int | float | str):
        return shown(value)
    raise Inconvertible(shown(value))


def _vector(value: Any) -> Vector3:
    if not isinstance(value, dict):
        raise Malformed(f"Error converting value {shown(value)} to type 'UnityEngine.Vector3'.")
    try:
        vector = Vector3(**{axis: _number(value[axis]) for axis in "xyz" if axis in value})
    except Inconvertible as error:
        raise Malformed(f"Could not convert to a component of a Vector3: {error}.") from None
    if max(abs(vector.x), abs(vector.y), abs(vector.z)) > MAX_COMPONENT:
        raise Malformed(f"A component of {shown(value)} is beyond {MAX_COMPONENT:g}.")
    return vector


def _partial_vector(value: Any) -> PartialVector3:
    if not isinstance(value, dict):
        raise Malformed(f"Error converting value {shown(value)} to type 'AgentManager+OptionalVector3'.")
    given = {axis: value[axis] for axis in "xyz" if value.get(axis) is not None}
    whole = _vector(given)
    return PartialVector3(**{axis: getattr(whole, axis) for axis in given})


def _object_pose(value: Any) -> ObjectPose:
    if not isinstance(value, dict):
        raise Malformed(f"Error converting value {shown(value)} to type 'ObjectPose'.")
    missing = [key for key in ("objectName", "position", "rotation") if key not in value]
    if missing:
        raise Malformed(f"Required property '{missing[0]}' not found in an ObjectPose.")
    try:
        name = _text(value["objectName"])
    except Inconvertible as error:
        raise Malformed(f"Could not convert the name of an object: {error}.") from None
    return ObjectPose(name, _vector(value["position"]), _vector(value["rotation"]))


_PLAIN = {
    float: _number,
    int: _integer,
    bool: _truth,
    str: _text,
    Vector3: _vector,
    PartialVector3: _partial_vector,
    ObjectPose: _object_pose,
}
