"""What a floor plan gives once and for all: its room, which parts belong to which bodies, forms to collide with, clearances."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from functools import cached_property

from ovman.engine.carrying import carriers
from ovman.engine.embodiment import Embodiment
from ovman.engine.floorplan import FloorPlan
from ovman.engine.footprint import Boxes
from ovman.engine.passage import DEEPER_M
from ovman.engine.room import Room
from ovman.engine.shapes import collision, compound

SKIN_M = 0.01
"""What the agent's controller keeps between its capsule and whatever blocks it."""
PASSABLE = frozenset(
    ["Floor", "Window", "Curtains", "Blinds", "Painting", "LightSwitch", "Mirror", "Poster", "Doorway", "Doorframe"]
)
"""Types whose boxes do not block the agent: hung on a wall, trodden on, or walked through. Behind a shut door there is a wall."""
WIDE_COUNTER_M = 1.2
"""Counters whose box is wider than this both ways are L- or U-shaped, and the agent stands in the box's opening."""
KEPT = 4
"""Floor plans that are remembered."""

_settings: OrderedDict[int, Setting] = OrderedDict()


class Setting:
    """The unchanging side of a world."""

    def __init__(self, plan: FloorPlan) -> None:
        self.plan = plan
        self.room = Room.of(plan)
        self.walls = Boxes.of([w.box for w in self.room.walls])
        self.carriers = carriers(plan)
        self._clearances: dict[Embodiment, dict[str, float]] = {}

    @staticmethod
    def of(plan: FloorPlan) -> Setting:
        """The setting of `plan`, made once for the last few plans."""
        found = _settings.get(id(plan))
        if found is None or found.plan is not plan:
            found = _settings[id(plan)] = Setting(plan)
        _settings.move_to_end(id(plan))
        while len(_settings) > KEPT:
            _settings.popitem(last=False)
        return found

    def clearances(self, embodiment: Embodiment) -> Mapping[str, float]:
        """How close, in metres, an agent may come to what is known to be smaller than its box: by names of walls and objectIds.

        An agent did stand at the recorded start: what its capsule would overlap there does not reach as far as its box does. And
        counters with an opening are walked into.
        """
        if embodiment not in self._clearances:
            self._clearances[embodiment] = _clearances(self.plan, self.room, embodiment)
        return self._clearances[embodiment]

    @cached_property
    def pieces(self) -> Mapping[str, tuple]:
        """Convex pieces of every object, in the frames of their boxes."""
        return {
            o.object_id: tuple(piece for part in compound(o, self.plan) for piece in collision(part)) for o in self.plan.objects
        }


def _clearances(plan: FloorPlan, room: Room, embodiment: Embodiment) -> dict[str, float]:
    boxes = {w.name: w.box for w in room.walls} | {o.object_id: o.box for o in plan.objects if o.type not in PASSABLE}
    low, high = embodiment.axis(float(plan.start[1]) + embodiment.foot_m)
    reach = embodiment.radius_m + SKIN_M
    at_start = Boxes.of(list(boxes.values())).distances(plan.start[None, [0, 2]], low, high, reach)[0]
    found = {name: max(float(d) - DEEPER_M, 0.0) for name, d in zip(boxes, at_start, strict=True) if d < reach}
    for o in plan.objects:
        first, last = o.box.bounds()
        if o.type == "CounterTop" and min((last - first)[[0, 2]]) > WIDE_COUNTER_M:
            found[o.object_id] = 0.0
    return found
