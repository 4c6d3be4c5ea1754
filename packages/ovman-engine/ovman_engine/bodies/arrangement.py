"""A scene arranged anew: which of its movable objects are there, how often, where, and what they are called then.

What AI2-THOR's SetObjectPoses does (`PhysicsSceneManager`): it hides everything movable, shows what is listed, and names what it
finds by where it stands.
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

    An object that is listed again, in place i of the list, is there again as name_copy_i. Returns the bodies listed, the new
    ones among them with their parts, and the last name that is none of a movable body.
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
    """Twins of a body and its parts, the body first."""
    twins = []
    for body in whole:
        twin = Body.of(body.obj)
        twin.name, twin.object_id = body.name + suffix, body.object_id + suffix
        twin.carrier = twins[0].object_id if twins else None
        twins.append(twin)
    return twins


def named(bodies: Iterable[Body]) -> dict[str, Body]:
    """`bodies` by the objectIds that their positions give them; what is where the floor plan has it keeps the recorded one.

    Carriers are renamed along. A body whose name is taken gets the suffix _copy.
    """
    renamed: dict[str, str] = {}
    out: dict[str, Body] = {}
    bodies = list(bodies)
    # What is gone must not keep a name from what is there; and a part's name may begin with its whole's.
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
    """objectId of an object of type `kind` whose pivot is at `position` (3,) metres, rounded as single-precision text is."""
    text = kind
    for value in position:
        number = abs(Decimal(f"{np.float32(value):.7g}")).quantize(Decimal("0.01"), ROUND_HALF_UP)
        text += f"|{'+' if value >= 0 else '-' if number else ''}{number:05.2f}"
    return text
