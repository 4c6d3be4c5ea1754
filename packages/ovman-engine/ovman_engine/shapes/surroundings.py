"""Evidence from the floor plan for a form: its front, its inserts, and whether it reaches the floor."""

from __future__ import annotations

from collections import OrderedDict

import numpy as np

from ovman_engine.plan.floorplan import FloorPlan, SimObject
from ovman_engine.shapes.part import about
from ovman_engine.shapes.subject import Insert

WALL_TYPES = frozenset(
    {"Window", "Painting", "Poster", "Mirror", "Blinds", "Curtains", "ShowerDoor", "ShowerGlass", "ShowerCurtain"}
)
"""Types that lie flat against a wall: the front is across the thinner side, towards the room."""
FITTED_TYPES = frozenset({"Cabinet", "Drawer", "TVStand", "Shelf", "StoveKnob", "SinkBasin", "ShelvingUnit"})
"""Types without a reliable rotation: the front is found from the objects before it."""
HOSTS = frozenset({"Dresser", "Desk", "SideTable", "TVStand", "ShelvingUnit", "CoffeeTable", "DiningTable", "Sink"})
"""Furniture that drawers, doors and shelves may be set into."""
UNDER_SINKS = frozenset({"Cabinet", "Drawer"})
"""Types that a sink may hang into from above."""
SEATS = frozenset({"Bed", "Sofa", "ArmChair"})
"""Types for which objects on them tell the height of the seat or the lying surface."""
INSERTS = {"Drawer": "drawer", "Cabinet": "door", "Shelf": "shelf"}
PILLOW_SIDE = 0.15
"""Pillows this far from the middle of a bed, in half its length, are at its head."""

REACH_M = (0.08, 0.3)
"""Distances before a front at which a fixed object blocks it."""
ASIDE_M = 0.1
"""An object nearer than this to the plane of a face is neither before nor behind it."""
SLACK_M = 0.03
"""How far a drawer may stick out of its furniture."""

_KEPT = 8
_OUTLINES: OrderedDict[int, tuple] = OrderedDict()


def direction(quarter: int) -> np.ndarray:
    """(3,) unit vector of +z after `quarter` quarter turns about y."""
    return np.array([(0, 0, 1), (1, 0, 0), (0, 0, -1), (-1, 0, 0)][quarter % 4], dtype=float)


def turn(quarter: int) -> np.ndarray:
    """Rotation (3, 3) of `quarter` quarter turns about y, taking +z to `direction(quarter)`."""
    return np.round(about("y", 90.0 * quarter))


def host(obj: SimObject, plan: FloorPlan) -> SimObject | None:
    """Return the smallest piece of furniture whose box holds `obj`'s box (to 3 cm in the plan), if any."""
    if obj.type not in INSERTS:
        return None
    low, high = obj.box.bounds()
    centre = (low + high) / 2
    holding = []
    for other in plan.objects:
        if other.type not in HOSTS:
            continue
        local = other.box.rotation.T @ (centre - other.box.centre)
        if (np.abs(local) <= other.box.half + SLACK_M).all() and (obj.box.half < other.box.half.max() + SLACK_M).all():
            holding.append((float(other.box.half.prod()), other.object_id, other))
    return min(holding, key=lambda h: h[:2])[2] if holding else None


def front(obj: SimObject, plan: FloorPlan) -> int:
    """Quarter turns about y from +z of the box to the front of `obj`."""
    if obj.type == "Bed":
        return _bed_front(obj, plan)
    if plan.house is not None:
        return 0
    if obj.type in WALL_TYPES:
        across = (0, 2) if obj.box.half[2] <= obj.box.half[0] else (1, 3)
        return max(across, key=lambda q: (_room_side(obj, plan, q), -q))
    owner = host(obj, plan)
    if owner is not None:
        ahead = obj.box.rotation.T @ owner.box.rotation @ direction(front(owner, plan))
        return max(range(4), key=lambda q: float(direction(q) @ ahead))
    if obj.type in FITTED_TYPES and not obj.dynamic:
        return max(range(4), key=lambda q: (round(_openness(obj, plan, q), 6), -q))
    if obj.type == "TVStand":
        return max((0, 2), key=lambda q: (_room_side(obj, plan, q), -q))
    return 0


def _bed_front(obj: SimObject, plan: FloorPlan) -> int:
    """Half turns to the foot of a bed: away from its pillows; the recorded beds have their heads at +z where none tells."""
    pillows = [o for o in plan.objects if o.type == "Pillow" and obj.object_id in o.parents]
    along = [float((obj.box.rotation.T @ (o.box.centre - obj.box.centre))[2]) for o in pillows]
    return 0 if along and np.mean(along) < -PILLOW_SIDE * obj.box.half[2] else 2


def _boxes(plan: FloorPlan) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[SimObject]]:
    """Lower and upper corners (N, 3) of all objects but the floor, the corners of the space they span, and the objects."""
    plan_kept, found = _OUTLINES.get(id(plan), (None, None))
    if plan_kept is not plan:
        objects = [o for o in plan.objects if o.type != "Floor"]
        bounds = np.array([np.concatenate(o.box.bounds()) for o in objects])
        room = np.concatenate([bounds[:, :3].min(axis=0), bounds[:, 3:].max(axis=0)])
        low, high = plan.floor.box.bounds()
        room[[0, 2]] = np.maximum(room[[0, 2]], low[[0, 2]])
        room[[3, 5]] = np.minimum(room[[3, 5]], high[[0, 2]])
        found = (bounds[:, :3], bounds[:, 3:], room, objects)
        _OUTLINES[id(plan)] = (plan, found)
        while len(_OUTLINES) > _KEPT:
            _OUTLINES.popitem(last=False)
    return found


def _room_side(obj: SimObject, plan: FloorPlan, quarter: int) -> float:
    """Score of how much of the room lies before a face: objects before it minus objects behind it.

    The agent's start counts most.
    """
    low, high, _, _ = _boxes(plan)
    normal = obj.box.rotation @ direction(quarter)
    ahead = ((low + high) / 2 - obj.box.centre) @ normal
    start = float(np.tanh((plan.start - obj.box.centre) @ normal)) * 0.5 * len(low)
    return float(np.sign(ahead[np.abs(ahead) > ASIDE_M]).sum() + start)


def _openness(obj: SimObject, plan: FloorPlan, quarter: int) -> float:
    """Score of a face as the front of something built in: free before it, not against a wall, at the hinge, towards the agent."""
    low, high, room, objects = _boxes(plan)
    ahead = obj.box.rotation @ direction(quarter)
    depth = obj.box.half[2] if quarter % 2 == 0 else obj.box.half[0]
    across = obj.box.half[0] if quarter % 2 == 0 else obj.box.half[2]
    face = obj.box.centre + ahead * depth
    blocked = 0
    for reach in REACH_M:
        probe = face + ahead * reach
        inside = ((probe >= low) & (probe <= high)).all(axis=1)
        blocked += any(objects[i] is not obj and not objects[i].dynamic for i in np.flatnonzero(inside))
    edge = min(
        (room[i + 3] - face[i]) * (ahead[i] > 0.5) + (face[i] - room[i]) * (ahead[i] < -0.5)
        for i in (0, 2)
        if abs(ahead[i]) > 0.5
    )
    hinge = abs((obj.position - face) @ ahead) < 0.06 if obj.type == "Cabinet" else False
    to_start = plan.start - face
    towards = float(to_start @ ahead / (np.linalg.norm(to_start[[0, 2]]) + 1e-9))
    return (
        towards + 1.0 * hinge - 1.0 * blocked - 1.5 * (edge < 0.35) + 0.6 * (across >= 0.6 * depth) + 0.5 * min(edge, 2.0) / 2.0
    )


def _overlap(first: SimObject, second: SimObject) -> bool:
    """Whether the boxes around two objects overlap."""
    (low, high), (other_low, other_high) = first.box.bounds(), second.box.bounds()
    return bool((np.minimum(high, other_high) > np.maximum(low, other_low)).all())


def inserts(obj: SimObject, plan: FloorPlan, quarter: int) -> tuple[Insert, ...]:
    """Return drawers, doors and shelves set into `obj`, sinks that hang into it, and objects that rest on a seat.

    They are in the frame of its `Subject`, with its front at +z.
    """
    if obj.type not in HOSTS | UNDER_SINKS | SEATS:
        return ()
    found = []
    to_local = turn(quarter).T @ obj.box.rotation.T
    half = np.abs(turn(quarter).T) @ obj.box.half
    for other in plan.objects:
        kind = INSERTS.get(other.type, "")
        if obj.type in UNDER_SINKS and other.type == "Sink" and _overlap(obj, other):
            kind = "sink"
        elif obj.type in SEATS and other.pickupable and obj.object_id in other.parents:
            kind = "rest"
        elif not kind or host(other, plan) is not obj:
            kind = ""
        if kind:
            corners = (other.box.corners() - obj.box.centre) @ to_local.T
            low, high = np.maximum(corners.min(axis=0), -half), np.minimum(corners.max(axis=0), half)
            if (high > low).all():
                up = half[1]
                found.append(Insert(kind, low[0], high[0], low[1] + up, high[1] + up, low[2], high[2]))
    return tuple(sorted(found))
