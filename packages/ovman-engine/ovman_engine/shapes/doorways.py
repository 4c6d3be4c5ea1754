"""Doors and floors of houses, in the frames of their oriented boxes."""

from __future__ import annotations

from ovman_engine.plan.floorplan import FloorPlan, SimObject
from ovman_engine.plan.house import rectangles
from ovman_engine.shapes.part import Part, span

JAMB_M = 0.05
"""Width of a frame's posts, and of its lintel."""
LEAF_M = 0.04
"""Thickness of a door's leaf."""
SADDLE_M = 0.004
KNOB_M, KNOB_HEIGHT_M = 0.025, 1.0
MAX_LEAF_M = 1.3
"""A wider doorway has two leaves."""
TYPES = frozenset(["Doorway", "Doorframe"])


def doorway(obj: SimObject) -> tuple[Part, ...]:
    """Frame, and leaves if it is a door. Leaves of an open door stand at right angles to the wall and do not collide.

    The box is the hole in the wall: x along the wall, z through it.
    """
    x, y, z = (float(v) for v in obj.box.half)
    jamb = min(JAMB_M, 0.2 * x)
    parts = [
        span((-x, -y, -z), (-x + jamb, y, z), "trim"),
        span((x - jamb, -y, -z), (x, y, z), "trim"),
        span((-x + jamb, y - jamb, -z), (x - jamb, y, z), "trim"),
    ]
    if obj.type == "Doorframe":
        return tuple(parts)
    inner, half = x - jamb, LEAF_M / 2
    double = 2 * x > MAX_LEAF_M
    width = inner if double else 2 * inner
    shut = not obj.record["isOpen"]
    for side in (-1, 1) if double else (-1,):
        hinge = side * inner
        if shut:
            ends = sorted((hinge, hinge - side * width))
            parts.append(span((ends[0], -y + SADDLE_M, -half), (ends[1], y - jamb, half), "main"))
            knob = hinge - side * (width - 0.07)
            low, high = (knob - KNOB_M, -half - 2 * KNOB_M), (knob + KNOB_M, half + 2 * KNOB_M)
        else:
            ends = sorted((hinge, hinge - side * LEAF_M))
            parts.append(span((ends[0], -y + SADDLE_M, -z - width), (ends[1], y - jamb, -z), "main", solid=False))
            reach = -z - width + 0.07
            low, high = (ends[0] - 2 * KNOB_M, reach - KNOB_M), (ends[1] + 2 * KNOB_M, reach + KNOB_M)
        at = -y + min(KNOB_HEIGHT_M, y)
        parts.append(span((low[0], at - KNOB_M, low[1]), (high[0], at + KNOB_M, high[1]), "metal", kind="ellipsoid", solid=False))
    return tuple(parts)


def floor(obj: SimObject, plan: FloorPlan) -> tuple[Part, ...]:
    """Return the floor of the room that `obj` is named after."""
    room = next(r for r in plan.house.rooms if r.name == obj.object_id)
    low, high = -obj.box.half[1], obj.box.half[1]
    x, _, z = obj.box.centre
    return tuple(span((a - x, low, c - z), (b - x, high, d - z)) for a, b, c, d in rectangles(room))
