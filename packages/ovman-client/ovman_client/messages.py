"""The messages of the protocol "ovman-agent/1" as bytes: MessagePack maps with arrays in raw form. Both sides use this module."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import msgpack
import numpy as np

from ovman_client.interface import Action, Camera, CameraPose, Context, Instruction, Observation, Query, Visit

PROTOCOL = "ovman-agent/1"
MAX_MESSAGE = 64 << 20
"""Bytes. A tour of 24 frames of 300 by 300 pixels has 15 MB."""
PICTURES = {"rgb": "|u1", "depth": "<f4"}
"""The arrays of a frame and their types, as numpy writes them."""
POSITIONS = "<f8"
"""The type of an array of positions."""


class MessageError(ValueError):
    """A message is not what the protocol says; one line."""


def packed(message: Mapping[str, Any]) -> bytes:
    """Return a message as bytes. Arrays in it become maps of `dtype`, `shape` and `data`, in C order and little-endian."""
    made: bytes = msgpack.packb(message, default=_array, use_bin_type=True)
    return made


def unpacked(data: object) -> dict[str, Any]:
    """Return the message that bytes hold: a map that has at least a `type`. MessageError for anything else."""
    if not isinstance(data, (bytes, bytearray)):
        raise MessageError("a message is a binary frame; this one is text")
    try:
        message = msgpack.unpackb(data, raw=False, strict_map_key=True)
    except Exception as error:  # msgpack raises a dozen types, and recursion and Unicode have theirs
        raise MessageError(f"no MessagePack: {type(error).__name__} {error}".rstrip()) from None
    if not isinstance(message, dict) or not isinstance(message.get("type"), str):
        raise MessageError('a message is a map with a text "type"')
    return message


def array(value: Any, dtype: str, dimensions: int) -> np.ndarray:
    """Return the array of a map of `dtype`, `shape` and `data`; it cannot be written to.

    MessageError if it is none of that type.
    """
    try:
        shape = tuple(value["shape"])
        if value["dtype"] != dtype or len(shape) != dimensions:
            raise MessageError(f"an array of {dimensions} dimensions and type {dtype} is expected")
        return np.frombuffer(value["data"], dtype).reshape(shape)
    except (KeyError, TypeError, ValueError) as error:
        raise MessageError(f"no array: {error}") from None


def query(value: Mapping[str, Any]) -> Query | Instruction:
    """Return the query of a message `ask`, without category and relation in the words track."""
    words = str(value.get("sentence", "")), str(value.get("phrase", ""))  # evaluators before 0.15 send none
    if "category" not in value and "relation" not in value:
        return Instruction(*words)
    return Query(str(value["category"]), str(value["relation"]), *words)


def observation(value: Mapping[str, Any]) -> Observation:
    """Return an observation of a message."""
    rgb = None if value["rgb"] is None else array(value["rgb"], PICTURES["rgb"], 3)
    depth = None if value["depth"] is None else array(value["depth"], PICTURES["depth"], 2)
    reachable = None if value["reachable"] is None else array(value["reachable"], POSITIONS, 2)
    pose = CameraPose(*(float(value["pose"][name]) for name in POSE))
    return Observation(rgb, depth, pose, float(value["field_of_view_deg"]), bool(value["last_action_succeeded"]), reachable)


POSE = ("x", "y", "z", "yaw_deg", "horizon_deg")


def visit(value: Mapping[str, Any]) -> Visit:
    """Return the visit of a message `familiarise` or `revisit`."""
    seen = tuple(observation(one) for one in value["observations"])
    return Visit(seen, array(value["reachable"], POSITIONS, 2), value["content"])


def context(value: Mapping[str, Any]) -> Context:
    """Return the context of a message `begin`."""
    words = {name: [int(word) for word in some] for name, some in value["words"].items()}
    constants = {name: value[name] for name in ("step_m", "turn_deg", "action_budget", "stall_after")}
    return Context(generator(words["picks"]), camera=Camera(**value["camera"]), words=words, **constants)


def generator(words: list[int]) -> np.random.Generator:
    """Return the generator that starts from four 64-bit words."""
    return np.random.Generator(np.random.PCG64(cast(Any, _Words(words))))


class _Words(np.random.bit_generator.ISeedSequence):  # type: ignore[misc, name-defined, unused-ignore]
    """A seed sequence that has been drawn from already."""

    def __init__(self, words: list[int]) -> None:
        self._words = np.array(words, np.uint64)

    def generate_state(self, n_words: int, dtype: Any = np.uint32) -> np.ndarray:
        if n_words != len(self._words) or np.dtype(dtype) != np.uint64:
            raise ValueError(f"{len(self._words)} words of 64 bits are there")
        return self._words


def action(value: object) -> Action | None:
    """Return the action that an agent returned, as itself or by its name; None for anything else."""
    try:
        return Action(getattr(value, "value", value))
    except ValueError:
        return None


def _array(value: object) -> dict[str, Any]:
    if not isinstance(value, np.ndarray):
        raise TypeError(f"no message has a {type(value).__name__}")
    ordered = np.ascontiguousarray(value, value.dtype.newbyteorder("<"))
    return {"dtype": ordered.dtype.str, "shape": list(ordered.shape), "data": ordered.tobytes()}
