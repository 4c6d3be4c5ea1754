"""Compares two answers to the same call key by key; states which keys may differ between Unity and the engine, and why.

Objects are compared by their names: an objectId contains the position at which it was assigned.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

from ovman.sim.recording.file import Call


@dataclass(frozen=True)
class Rule:
    """Keys that may differ.

    keys: patterns of "action:key"; within: largest difference (metres, degrees), None for any; why: the reason.
    """

    keys: tuple[str, ...]
    within: float | None
    why: str


STILL = (
    *("start", "reset", "Pass", "GetReachablePositions", "SetObjectFilter"),
    *("DisableObject", "PlaceObjectAtPoint", "TeleportObject"),
)
DRIVEN = ("MoveAhead", "RotateLeft", "RotateRight")
STATE = ("agent.*", "cameraPosition.*", "objects.distance", "lastActionSuccess", "errorMessage", "errorCode")

RULES: Sequence[Rule] = (
    Rule(("*:pictures.*", "*:colors"), None, "rooms and objects are modelled by rule, not taken from AI2-THOR's assets"),
    Rule(("*:objects.visible", "*:objects.isInteractable"), None,
         "the engine sees the triangles that it draws, Unity points that artists set"),
    Rule(("GetReachablePositions:actionReturn", "*:sceneBounds.*"), None, "the engine infers the walls of a room"),
    Rule(tuple(f"{action}:{key}" for action in DRIVEN for key in STATE), None,
         "a move may be free in one room and blocked in the other; what is driven after it begins elsewhere"),
    Rule(tuple(f"{action}:agent.rotation.*" for action in STILL), None, "AI2-THOR's yaw at the start is not recorded anywhere"),
    Rule(("*:agent.position.*", "*:cameraPosition.*"), 0.05, "start heights are recorded to centimetres"),
    Rule(("*:agent.rotation.*", "*:agent.cameraHorizon"), 0.1, "angles are single precision in Unity"),
    Rule(("*:objects.position.*", "*:objects.axisAlignedBoundingBox.*", "*:objects.objectOrientedBoundingBox.*",
          "PlaceObjectAtPoint:actionReturn.*"), 0.05, "things come to rest by another program's physics"),
    Rule(("*:objects.distance",), 0.1, "follows from the positions"),
    Rule(("*:objects.rotation.*",), 5.0, "things come to rest by another program's physics"),
    Rule(("*:isSceneAtRest", "*:objects.isMoving", "*:currentTime"), None,
         "in Unity time runs on between actions, and untouched things still settle"),
    Rule(("*:objects.parentReceptacles", "*:objects.receptacleObjectIds"), None,
         "the engine reads from boxes what stands on what, Unity from trigger volumes"),
    Rule(("*:collided", "*:collidedObjects", "*:heldObjectPose.*"), None, "the engine's agent has no hand and pushes nothing"),
)  # fmt: skip
"""For the engine against Unity; the first rule that matches counts. Two recordings of one simulator must be equal."""


@dataclass(frozen=True)
class Difference:
    """One key of one answer. by: the difference of two numbers, or the share of points that only one of two sets has."""

    line: int
    key: str
    recorded: Any
    answered: Any
    by: float | None


@dataclass(frozen=True)
class Summary:
    """All differences of a key over all actions that match the same rule. rule: None if no rule matches."""

    key: str
    rule: Rule | None
    count: int
    first: Difference
    largest: float | None

    def __str__(self) -> str:
        """One line."""
        by = "" if self.largest is None else f", by up to {self.largest:.4g}"
        shown = f"{_short(self.first.recorded)} was recorded, {_short(self.first.answered)} answered"
        after = self.first.key.partition(":")[0]
        return f"{self.key}: {self.count} times{by}; first in line {self.first.line} ({after}): {shown}"


def differences(line: int, recorded: Call, answered: Call) -> Iterator[Difference]:
    """Every key that differs between two answers to the call on a line of the recording."""
    action = str(recorded.arguments.get("action", recorded.call))
    for key, was, now in _pairs("", _comparable(recorded), _comparable(answered)):
        yield Difference(line, f"{action}:{key}", was, now, _distance(key, was, now))


def allowed(difference: Difference, rules: Sequence[Rule]) -> Rule | None:
    """The first rule that allows a difference, None if no rule does."""
    rule = next((r for r in rules if any(fnmatchcase(difference.key, key) for key in r.keys)), None)
    if rule is None or rule.within is None:
        return rule
    return rule if difference.by is not None and difference.by <= rule.within else None


def summaries(found: Sequence[Difference], rules: Sequence[Rule]) -> list[Summary]:
    """Differences by key; those that no rule allows come first."""
    groups: dict[tuple[str, Rule | None], list[Difference]] = {}
    for difference in found:
        groups.setdefault((difference.key.partition(":")[2], allowed(difference, rules)), []).append(difference)
    made = [
        Summary(key, rule, len(all_of), all_of[0], max((d.by for d in all_of if d.by is not None), default=None))
        for (key, rule), all_of in groups.items()
    ]
    return sorted(made, key=lambda s: (s.rule is not None, s.key))


class _Named(dict[str, Any]):
    """Objects by name; the names are left out of the keys of differences."""


class _Points(frozenset[tuple[float, ...]]):
    """Unordered positions, rounded to the millimetre."""

    def __repr__(self) -> str:
        return f"{len(self)} points"


def _comparable(call: Call) -> Mapping[str, Any]:
    """The answer of a call with its objects by name, and its points as a set."""
    if call.metadata is None:
        return {"error": call.error}
    answer = dict(call.metadata)
    answer["objects"] = _Named({o["name"]: o for o in answer.get("objects") or []})
    given = answer.get("actionReturn")
    if isinstance(given, list) and given and all(isinstance(p, Mapping) and p.keys() == {"x", "y", "z"} for p in given):
        answer["actionReturn"] = _Points(tuple(round(p[axis], 3) for axis in "xyz") for p in given)
    return {**answer, "pictures": call.pictures, "error": None}


def _pairs(path: str, was: Any, now: Any) -> Iterator[tuple[str, Any, Any]]:
    """Leaves that differ. A key that only one side has is paired with None."""
    if was == now:
        return
    if isinstance(was, Mapping) and isinstance(now, Mapping):
        for key in [*was, *(k for k in now if k not in was)]:
            below = path if isinstance(was, _Named) else f"{path}.{key}".lstrip(".")
            if key not in was or key not in now:
                yield below, key if key in was else None, key if key in now else None
            else:
                yield from _pairs(below, was[key], now[key])
    elif _vectors(was, now):
        for k, (a, b) in enumerate(zip(was, now, strict=True)):
            yield from _pairs(f"{path}.{k}", a, b)
    else:
        yield path, was, now


def _vectors(was: Any, now: Any) -> bool:
    """Whether both are lists of equally many numbers, or of such lists (corners of boxes)."""
    if not (isinstance(was, list) and isinstance(now, list) and len(was) == len(now)):
        return False
    return all((_is_number(a) and _is_number(b)) or _vectors(a, b) for a, b in zip(was, now, strict=True))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _distance(key: str, was: Any, now: Any) -> float | None:
    if isinstance(was, _Points) and isinstance(now, _Points):
        return 1.0 - len(was & now) / len(was | now)
    if not (_is_number(was) and _is_number(now)):
        return None
    apart = abs(was - now)
    return min(apart % 360.0, -apart % 360.0) if "rotation" in key else apart if math.isfinite(apart) else None


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
