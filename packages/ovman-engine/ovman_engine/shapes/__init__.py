"""Shapes: one table from an object's type to a compound of parts in its oriented box, for drawing and collision alike."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ovman_engine.plan.floorplan import FloorPlan, SimObject
from ovman_engine.shapes import (
    appliances,
    bedding,
    beds,
    belongings,
    bins,
    bottles,
    built_in,
    cleaning,
    cutlery,
    decor,
    doorways,
    electronics,
    fittings,
    food,
    hangings,
    lamps,
    paper,
    plants,
    sanitary,
    seating,
    showers,
    statues,
    storage,
    surroundings,
    tables,
    tableware,
)
from ovman_engine.shapes.built_in import bodies, stoves
from ovman_engine.shapes.collision import collision
from ovman_engine.shapes.fit import Form, fitted
from ovman_engine.shapes.part import Part, moved, span
from ovman_engine.shapes.style import Style
from ovman_engine.shapes.subject import Insert, Subject
from ovman_engine.shapes.tessellation import mesh

__all__ = ["FORMS", "LOOSE", "Part", "bodies", "collision", "compound", "drawn", "mesh", "stoves"]

FORMS: dict[str, Form] = {}
for _module in (
    appliances,
    bedding,
    beds,
    belongings,
    bins,
    bottles,
    cleaning,
    cutlery,
    decor,
    electronics,
    fittings,
    food,
    hangings,
    lamps,
    paper,
    plants,
    sanitary,
    seating,
    showers,
    statues,
    storage,
    tables,
    tableware,
):
    FORMS.update(_module.FORMS)

LOOSE = frozenset({"Shelf", "CounterTop"})
"""Types that do not fill their box: that of a shelf includes the space above the board, that of a counter the space it
encloses."""
_SMALLEST_M = 1e-3


def _plain(s: Subject) -> tuple[Part, ...]:
    return (span((-s.x, 0, -s.z), (s.x, s.h, s.z), bevel=min(0.01, 0.2 * min(s.w, s.h, s.d))),)


@lru_cache(maxsize=512)
def _compound(
    kind: str, size: tuple[float, ...], key: str, inserts: tuple[Insert, ...], hung: bool, quarter: int
) -> tuple[Part, ...]:
    """Return the compound of one asset, cached: every world of a floor plan needs the same."""
    width, height, depth = size if quarter % 2 == 0 else (size[2], size[1], size[0])
    subject = Subject(kind, width, height, depth, Style(key), inserts, hung)
    if kind in LOOSE:
        parts = tuple(p.but(centre=p.centre - [0, height / 2, 0]) for p in FORMS[kind](subject))
    else:
        parts = fitted(FORMS.get(kind, _plain), subject)
    return moved(parts, surroundings.turn(quarter))


def compound(obj: SimObject, plan: FloorPlan) -> tuple[Part, ...]:
    """Parts of `obj` in the frame of its oriented box: origin at its centre, metres.

    The drawn parts touch all six faces of the box and stay within it to 1 mm, except for the types in `LOOSE`. The result is a
    function of the asset (of the name without one) and, for built-in objects, of the surroundings.
    """
    if obj.type == "CounterTop":
        return built_in.counter(obj, plan)
    if built_in.is_angled_desk(obj, plan):
        return built_in.angled_desk(obj, plan)
    if obj.type in doorways.TYPES:
        return doorways.doorway(obj)
    if obj.type == "Floor" and plan.house is not None:
        return doorways.floor(obj, plan)
    quarter = surroundings.front(obj, plan)
    low, _ = obj.box.bounds()
    size = tuple(float(v) for v in np.maximum(2 * obj.box.half, _SMALLEST_M))
    hung = bool(low[1] > plan.floor_y + 0.25)
    return _compound(obj.type, size, obj.asset_id or obj.name, surroundings.inserts(obj, plan, quarter), hung, quarter)


def drawn(obj: SimObject, plan: FloorPlan) -> tuple[Part, ...]:
    """Return the parts of `compound` that are drawn with the object: of a counter only the slab.

    `bodies` gives what it stands on.
    """
    return built_in.slab(obj, plan) if obj.type == "CounterTop" else compound(obj, plan)
