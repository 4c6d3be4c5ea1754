"""Counters, desks around a corner, and stoves, which are fitted to the room rather than to a box of their own."""

from __future__ import annotations

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np

from ovman_engine.plan import counters
from ovman_engine.plan.counters import Rect
from ovman_engine.plan.floorplan import FloorPlan, SimObject
from ovman_engine.shapes import surroundings
from ovman_engine.shapes.fronts import doors, drawers, handle
from ovman_engine.shapes.part import Part, about, moved, rod, span
from ovman_engine.shapes.style import Style
from ovman_engine.shapes.subject import Subject

SLAB_M = 0.03
"""Thickness of a counter's slab."""
RECESS_M = 0.09
"""Distance of a counter's body from its front edge, so that doors and drawers stand in front of it."""
OVERHANG_M = 0.25
"""Overhang of a counter without base units: room for knees."""
TOE_M = 0.09
WIDE_DESK_M = 1.1
"""A desk whose box is wider than this both ways runs around a corner, in which the agent can stand."""
DESK_M = 0.03
"""Thickness of the top and of the ends of such a desk."""
UNIT_SLAB_M, UNIT_M, HOB_M = 0.04, 0.6, 0.58
"""Of kitchen units in houses: thickness of the slab, width of a door, width of the hob."""
_COUNTERS: WeakKeyDictionary[FloorPlan, dict[str, tuple[Part, ...]]] = WeakKeyDictionary()


def counter(obj: SimObject, plan: FloorPlan) -> tuple[Part, ...]:
    """Slab with openings for sinks, and a body under it to the floor, in the frame of the counter's box; metres."""
    found = _COUNTERS.setdefault(plan, {})
    if obj.object_id not in found:
        found[obj.object_id] = _counter(obj, plan) if plan.house is None else _unit(obj, plan)
    return found[obj.object_id]


def _unit(obj: SimObject, plan: FloorPlan) -> tuple[Part, ...]:
    """Return a kitchen unit of a house: slab, body with doors and drawers, and a hob where there is room for one.

    Its asset stands on the floor and has its front at +z. Sinks that it holds hang into it.
    """
    x, y, z = obj.box.half
    style, under, toe, face = Style(obj.asset_id), y - UNIT_SLAB_M, TOE_M - y, z - 0.03
    holes, deepest = [], under
    for sink in (o for o in plan.objects if o.type == "Sink" and obj.object_id in o.parents):
        corners = (sink.box.corners() - obj.box.centre) @ obj.box.rotation
        low, high = corners.min(axis=0), corners.max(axis=0)
        holes.append(Rect(low[0] + 0.01, low[2] + 0.01, high[0] - 0.01, high[2] - 0.01))
        deepest = min(deepest, float(low[1]) - 0.01)
    parts = [span((p.x0, under, p.z0), (p.x1, y, p.z1)) for p in counters.without(Rect(-x, -z, x, z), tuple(holes))]
    parts.append(span((-x, toe, -z), (x, deepest, face), "second"))
    if holes:
        around = counters.without(Rect(-x, -z, x, face), tuple(holes))
        parts += [span((p.x0, deepest, p.z0), (p.x1, under, p.z1), "second") for p in around]
    parts.append(span((-x, -y, -z), (x, toe, face - 0.06), "dark"))
    columns = max(1, round(2 * x / UNIT_M))
    wide = 2 * x / columns
    for k in range(columns):
        left, rows = -x + k * wide, 3 if style.chance(f"drawers {k}", 0.35) else 0
        if rows:
            parts += drawers((left, left + wide, toe, under), face, style, rows, 1, reach=0.03)
        else:
            parts += doors((left, left + wide, toe, under), face, style, 1, reach=0.03)
    sides = [(-x, min((h.x0 for h in holes), default=x)), (max((h.x1 for h in holes), default=-x), x)]
    low, high = max(sides, key=lambda side: side[1] - side[0])
    if high - low > HOB_M + 0.2:
        middle, half = (low + high) / 2, HOB_M / 2
        parts.append(span((middle - half, y - 0.01, -0.24), (middle + half, y, 0.24), "dark", solid=False))
    return tuple(parts)


BODY_SLOTS = frozenset({"second", "dark"})
"""Slots of a counter's body; the slab is "main"."""


def slab(obj: SimObject, plan: FloorPlan) -> tuple[Part, ...]:
    """Return what is drawn with a counter, in the frame of its box, metres: in a floor plan the slab alone."""
    parts = counter(obj, plan)
    return parts if plan.house is not None else tuple(part for part in parts if part.slot not in BODY_SLOTS)


def bodies(plan: FloorPlan) -> tuple[tuple[SimObject, tuple[Part, ...]], ...]:
    """Counters of a plan, and the bodies under their slabs in the world frame, metres. Bodies are no part of recorded objects."""
    found = []
    for obj in plan.objects if plan.house is None else ():
        if obj.type == "CounterTop":
            parts = tuple(part for part in counter(obj, plan) if part.slot in BODY_SLOTS)
            if parts:
                found.append((obj, moved(parts, obj.box.rotation, obj.box.centre)))
    return tuple(found)


def _counter(obj: SimObject, plan: FloorPlan) -> tuple[Part, ...]:
    low, high = obj.box.bounds()
    # A thin box is the space right above the slab: recorded objects rest on its bottom.
    top = float(low[1] if high[1] - low[1] < SLAB_M else high[1])
    under = top - SLAB_M
    units = counters.carriers(plan, obj)
    holes = tuple(
        Rect(f.x0 + 0.01, f.z0 + 0.01, f.x1 - 0.01, f.z1 - 0.01)
        for f in (counters.footprint(u) for u in units if u.type == "Sink" and u.box.bounds()[1][1] > under - 0.12)
    )
    rects = counters.runs(plan, obj)
    parts: list[Part] = []
    for rect in rects:
        for piece in counters.without(rect, holes):
            parts.append(span((piece.x0, under, piece.z0), (piece.x1, top, piece.z1), "main"))
        for body in _bodies(plan, rect, rects, units):
            toe = plan.floor_y + TOE_M
            if under - toe < 0.1:
                continue
            sunk = counters.without(body, holes)
            deepest = min((float(u.box.bounds()[0][1]) for u in units if u.type == "Sink"), default=under)
            if len(sunk) > 1 and deepest > toe + 0.1:
                parts.append(span((body.x0, toe, body.z0), (body.x1, min(under, deepest - 0.01), body.z1), "second"))
                for piece in sunk:
                    if deepest - 0.01 < under:
                        parts.append(
                            span((piece.x0, deepest - 0.01, piece.z0), (piece.x1, under, piece.z1), "second", solid=False)
                        )
            elif len(sunk) == 1:
                parts.append(span((body.x0, toe, body.z0), (body.x1, under, body.z1), "second"))
            inset = min(0.04, 0.2 * min(body.x1 - body.x0, body.z1 - body.z0))
            floor = (body.x0 + inset, plan.floor_y, body.z0 + inset)
            parts.append(span(floor, (body.x1 - inset, toe, body.z1 - inset), "dark", solid=False))
    to_box = obj.box.rotation.T
    return moved(parts, to_box, -to_box @ obj.box.centre)


def is_angled_desk(obj: SimObject, plan: FloorPlan) -> bool:
    """Whether an object of a floor plan is a desk that runs around a corner."""
    return plan.house is None and obj.type == "Desk" and 2 * min(obj.box.half[0], obj.box.half[2]) > WIDE_DESK_M


def angled_desk(obj: SimObject, plan: FloorPlan) -> tuple[Part, ...]:
    """Return a top in the runs of a counter of the same box, and a panel at both ends of each run, in the frame of the box."""
    low, high = obj.box.bounds()
    bottom, top = float(low[1]), float(high[1])
    parts: list[Part] = []
    for run in counters.runs(plan, obj):
        parts.append(span((run.x0, top - DESK_M, run.z0), (run.x1, top, run.z1), "main", bevel=0.006))
        along_x = run.x1 - run.x0 > run.z1 - run.z0
        for first in (True, False):
            x0 = run.x1 - DESK_M if along_x and not first else run.x0
            z0 = run.z1 - DESK_M if not along_x and not first else run.z0
            x1, z1 = (x0 + DESK_M, run.z1) if along_x else (run.x1, z0 + DESK_M)
            parts.append(span((x0, bottom, z0), (x1, top - DESK_M, z1), "main"))
    to_box = obj.box.rotation.T
    return moved(parts, to_box, -to_box @ obj.box.centre)


def _bodies(plan: FloorPlan, rect: Rect, rects: tuple[Rect, ...], units: list[SimObject]) -> Iterator[Rect]:
    """Yield the parts that close the space under a run, set back from open edges."""
    prints = [(u, counters.footprint(u)) for u in units if u.type in ("Cabinet", "Drawer")]
    here = [(u, f) for u, f in prints if rect.overlap(f)]
    if not here and rect.x1 - rect.x0 > 2 * OVERHANG_M and rect.z1 - rect.z0 > 2 * OVERHANG_M and len(rects) == 1:
        recess = [
            _open_edge(plan, rect, side) * min(OVERHANG_M, 0.3 * min(rect.x1 - rect.x0, rect.z1 - rect.z0)) for side in range(4)
        ]
    else:
        recess = [0.0] * 4
        for unit, print_ in here:
            ahead = unit.box.rotation @ surroundings.direction(surroundings.front(unit, plan))
            side = int(np.argmax([-ahead[0], -ahead[2], ahead[0], ahead[2]]))
            front = (print_.x0 - rect.x0, print_.z0 - rect.z0, rect.x1 - print_.x1, rect.z1 - print_.z1)[side]
            recess[side] = max(recess[side], min(max(front, 0.0) + RECESS_M, 0.3))
        for side in range(4):
            if recess[side] == 0.0 and _open_edge(plan, rect, side):
                recess[side] = 0.03
    for side, other in ((s, r) for s in range(4) for r in rects if r is not rect):
        edge = (rect.x0, rect.z0, rect.x1, rect.z1)[side]
        far = (other.x1, other.z1, other.x0, other.z0)[side]
        if abs(edge - far) < 1e-6:
            recess[side] = min(recess[side], 0.0)
    body = Rect(rect.x0 + recess[0], rect.z0 + recess[1], rect.x1 - recess[2], rect.z1 - recess[3])
    if body.x1 - body.x0 > 0.08 and body.z1 - body.z0 > 0.08:
        yield body


def _open_edge(plan: FloorPlan, rect: Rect, side: int) -> bool:
    """Whether the agent's start lies beyond that side: low x, low z, high x, high z."""
    x, z = float(plan.start[0]), float(plan.start[2])
    return (x < rect.x0, z < rect.z0, x > rect.x1, z > rect.z1)[side]


def stoves(plan: FloorPlan) -> tuple[tuple[str, SimObject, tuple[Part, ...]], ...]:
    """Stove bodies under the recorded burners: "stove|x|y|z", the burner whose palette they take, parts in the world frame."""
    found = []
    for stove in counters.stoves(plan):
        rect = stove.rect
        x, z = (rect.x0 + rect.x1) / 2, (rect.z0 + rect.z1) / 2
        wide, deep = rect.x1 - rect.x0, rect.z1 - rect.z0
        if stove.quarter % 2:
            wide, deep = deep, wide
        subject = Subject("Stove", wide, stove.top - plan.floor_y, deep, Style(plan.name + "|stove"))
        parts = moved(_stove(subject), surroundings.turn(stove.quarter), (x, plan.floor_y, z))
        found.append((f"stove|{x:+06.2f}|{plan.floor_y:+06.2f}|{z:+06.2f}", stove.burner, parts))
    return tuple(found)


def _stove(s: Subject) -> Iterator[Part]:
    """Body, hob, oven door with window and handle, drawer."""
    face = s.z - 0.05
    yield span((-s.x, 0.06, -s.z), (s.x, s.h - 0.02, face), "main", bevel=0.004)
    yield span((-s.x + 0.03, 0, -s.z), (s.x - 0.03, 0.06, face - 0.04), "dark", solid=False)
    yield span((-s.x, s.h - 0.02, -s.z), (s.x, s.h, face + 0.02), "second", bevel=0.004)
    low, high = 0.24 * s.h, 0.84 * s.h
    yield span((-s.x + 0.01, low, face), (s.x - 0.01, high, face + 0.018), "main", bevel=0.006, solid=False)
    yield span(
        (-0.62 * s.x, low + 0.12 * s.h, face + 0.01),
        (0.62 * s.x, high - 0.16 * s.h, face + 0.02),
        "dark",
        bevel=0.003,
        solid=False,
    )
    yield span((-s.x + 0.01, 0.07, face), (s.x - 0.01, low - 0.01, face + 0.018), "main", bevel=0.006, solid=False)
    yield from handle(0.0, high - 0.05, face + 0.018, s.style, False, 1.5 * s.x, 0.03)
    yield span((-s.x + 0.01, high + 0.01, face), (s.x - 0.01, s.h - 0.03, face + 0.012), "dark", bevel=0.003, solid=False)
    for i in range(5):
        x = (i - 2) * 0.36 * s.x
        yield rod(
            (x, 0.5 * (high + s.h) - 0.01, face), (x, 0.5 * (high + s.h) - 0.01, face + 0.03), 0.02, "metal", solid=False
        ).but(rotation=about("x", 90.0))
