"""SetObjectPoses: shows the listed movable objects at their poses, and hides all others.

Source: AI2-THOR's `PhysicsSceneManager`, which also makes copies of objects that are listed twice, and renames objects by their
positions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import ROUND_HALF_UP, Decimal
from typing import Any

import numpy as np

from ovman_engine.bodies.body import Body, Pose
from ovman_engine.bodies.carrying import move

PartsOf = Callable[[Body], list[Body]]


def arranged(
    bodies: Sequence[Body], poses: Sequence[Mapping[str, Any]], parts_of: PartsOf
) -> tuple[list[Body], list[Body], str | None]:
    """Hides all movable `bodies` and shows those of `poses`, [{objectName, position (3,), rotation (3, 3)}, ...].

    An object that is listed again, at index i, appears again as name_copy_i. Returns the listed bodies, the copies with their
    parts, and the last listed name that no movable body has.
    """
    movable = {b.name: b for b in bodies if b.dynamic}
    hidden = {name: [b, *(p for p in parts_of(b) if p.active)] for name, b in movable.items()}
    for whole in hidden.values():
        for body in whole:
            body.active = False
    listed: list[Body] = []
    copies: list[Body] = []
    unknown = None
    for place, pose in enumerate(poses):
        name = pose["objectName"]
        if name not in movable:
            unknown = name
            continue
        whole = hidden[name]
        if whole[0].active:
            whole = _copied(whole, f"_copy_{place}")
            copies += whole
        for body in whole:
            body.active, body.velocity = True, np.zeros(6)
        move(whole[0], whole[1:], Pose(np.array(pose["position"], dtype=float), np.array(pose["rotation"], dtype=float)))
        listed.append(whole[0])
    return listed, copies, unknown


def _copied(whole: Sequence[Body], suffix: str) -> list[Body]:
    """Copy of a body and its parts, the body first."""
    twins: list[Body] = []
    for body in whole:
        twin = Body.of(body.obj)
        twin.name, twin.object_id = body.name + suffix, body.object_id + suffix
        twin.carrier = twins[0].object_id if twins else None
        twins.append(twin)
    return twins


def named(bodies: Iterable[Body]) -> dict[str, Body]:
    """`bodies` by objectId. Ids follow from positions; a body where the floor plan has it keeps its recorded id.

    References to carriers are updated. A body whose id is taken gets the suffix _copy.
    """
    renamed: dict[str, str] = {}
    out: dict[str, Body] = {}
    bodies = list(bodies)
    # Removed bodies come last, so that they take no id from present ones; parts follow carriers, whose id theirs may begin with.
    for body in sorted(bodies, key=lambda b: (b.removed, b.carrier is not None)):
        former = body.object_id
        body.object_id = body.obj.object_id if body.untouched else _moved_id(body, renamed)
        while body.object_id in out:
            body.object_id += "_copy"
        renamed[former] = body.object_id
        out[body.object_id] = body
    for body in bodies:
        if body.carrier is not None:
            body.carrier = renamed.get(body.carrier, body.carrier)
    return {b.object_id: b for b in bodies}


def _moved_id(body: Body, renamed: Mapping[str, str]) -> str:
    whole, _, kind = body.obj.object_id.rpartition("|")
    if whole.count("|") == 3 and kind.isalpha():
        return f"{renamed.get(body.carrier or whole, whole)}|{kind}"
    return object_id(body.obj.type, body.pose.position)


def object_id(kind: str, position: np.ndarray) -> str:
    """Return the objectId of an object of type `kind` with its pivot at `position` (3,) metres.

    Coordinates are rounded like single-precision text.
    """
    text = kind
    for value in position:
        number = abs(Decimal(f"{np.float32(value):.7g}")).quantize(Decimal("0.01"), ROUND_HALF_UP)
        text += f"|{'+' if value >= 0 else '-' if number else ''}{number:05.2f}"
    return text
