"""What moves with a body: its parts, and the objects that it carries."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from ovman_engine.bodies.body import Body, Pose
from ovman_engine.plan.floorplan import Box, FloorPlan

INSIDE = 0.5
"""Fraction of a part's box that lies inside its carrier's box."""
RESTS_M = 0.05
"""Distance above or below a surface at which an object rests on it: recorded boxes are not exact."""
RISES_M = 0.005
"""An object on a body has its underside at least this far above the body's underside, or half the body's height if that is less:
of two thin objects side by side, both undersides are on the table."""
STANDS_M = 0.01
"""An object this close to the floor stands on it."""
PARTS = frozenset(["Cabinet", "Drawer", "Shelf"])
"""Fixed types that are parts of movable furniture."""

Surfaces = Callable[[Body], list[Box]]
PartsOf = Callable[[str], list[Body]]


def carriers(plan: FloorPlan) -> dict[str, str]:
    """Map the objectId of a fixed part (a drawer) to the objectId of the movable receptacle it belongs to (its dresser)."""
    movable = [o for o in plan.objects if o.moveable and o.record["receptacle"]]
    out = {}
    for part in plan.objects:
        if part.type not in PARTS or part.dynamic or not movable:
            continue
        share = np.array([_share_inside(part.box, m.box) for m in movable])
        best = int(share.argmax())
        if share[best] >= INSIDE:
            out[part.object_id] = movable[best].object_id
    return out


def _share_inside(inner: Box, outer: Box) -> float:
    corners = (inner.corners() - outer.centre) @ outer.rotation
    low, high = corners.min(axis=0), corners.max(axis=0)
    common = np.minimum(high, outer.half) - np.maximum(low, -outer.half)
    return float(np.prod(np.maximum(common, 0.0)) / max(np.prod(high - low), 1e-12))


def move(body: Body, parts: Iterable[Body], pose: Pose) -> None:
    """Move a body and its parts rigidly, the body to `pose`."""
    turn = pose.rotation @ body.obj.rotation.T
    body.pose = pose
    for part in parts:
        offset = part.obj.position - body.obj.position
        part.pose = Pose(pose.position + turn @ offset, turn @ part.obj.rotation)


def resting(surfaces: Sequence[Box], others: Sequence[Body], floor_y: float) -> set[str]:
    """Return the objectIds of those of `others` that rest on one of `surfaces` and not on the floor.

    surfaces: boxes around the pieces of a body.
    """
    if not others or not surfaces:
        return set()
    low, high = _bounds([b.box for b in others])
    piece_low, piece_high = _bounds(surfaces)
    over = np.abs(low[:, None, 1] - piece_high[None, :, 1]) <= RESTS_M
    for axis in (0, 2):
        over &= (low[:, None, axis] < piece_high[None, :, axis]) & (high[:, None, axis] > piece_low[None, :, axis])
    foot, top = piece_low[:, 1].min(), piece_high[:, 1].max()
    rests = over.any(axis=1) & (low[:, 1] > max(floor_y + STANDS_M, foot + min(RISES_M, (top - foot) / 2)))
    return {b.object_id for b, yes in zip(others, rests, strict=True) if yes}


def inside(body: Body, parts: Iterable[str], others: Sequence[Body], floor_y: float) -> set[str]:
    """Return the objectIds of those of `others` that lie in `body` or its `parts`.

    They are recorded there, and still in the body's box.
    """
    names = {body.obj.object_id, *parts}
    recorded = [b for b in others if b.untouched and not names.isdisjoint(b.obj.parents)]
    if not recorded:
        return set()
    low, high = _bounds([b.box for b in recorded])
    box = body.box
    within = (np.abs(((low + high) / 2 - box.centre) @ box.rotation) <= box.half).all(axis=1) & (low[:, 1] > floor_y + STANDS_M)
    return {b.object_id for b, yes in zip(recorded, within, strict=True) if yes}


def load_of(body: Body, bodies: Mapping[str, Body], surfaces: Surfaces, parts: PartsOf, floor_y: float) -> list[str]:
    """Return the objectIds of what `body` carries among `bodies`, directly and indirectly; empty if the body is not present.

    `surfaces` returns the boxes around the pieces of a body, `parts` the parts of a body by its objectId.
    """
    found: list[str] = []
    queue = [body] if body.present else []
    while queue:
        for name in sorted(_carried(queue.pop(), bodies, surfaces, parts, floor_y)):
            if name not in found and name != body.object_id:
                found.append(name)
                queue.append(bodies[name])
    return found


def _carried(body: Body, bodies: Mapping[str, Body], surfaces: Surfaces, parts: PartsOf, floor_y: float) -> set[str]:
    """Return the objectIds of what rests on a body, and of what lies in it and rests on nothing else."""
    others = [b for b in bodies.values() if b is not body and b.dynamic and not b.removed and not b.kinematic]
    found = resting(surfaces(body), others, floor_y)
    own = {body.object_id, *(p.object_id for p in parts(body.object_id))}
    for name in inside(body, own, others, floor_y) - found:
        parents = (bodies.get(parent) for parent in bodies[name].obj.parents if parent not in own)
        standing = [p for p in parents if p is not None and p.present and p.obj.type != "Floor"]
        if not any(resting(surfaces(p), [bodies[name]], floor_y) for p in standing):
            found.add(name)
    return found


def _bounds(boxes: Sequence[Box]) -> tuple[np.ndarray, np.ndarray]:
    bounds = [b.bounds() for b in boxes]
    return np.array([b[0] for b in bounds]), np.array([b[1] for b in bounds])
