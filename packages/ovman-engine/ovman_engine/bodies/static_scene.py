"""What does not change in a floor plan: its room, parts of furniture, collision pieces, clearances of the agent."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from ovman_engine.bodies.carrying import carriers
from ovman_engine.bodies.embodiment import DEFAULT, Embodiment
from ovman_engine.bodies.footprint import Boxes
from ovman_engine.bodies.forms import FOOT_M, extent, feet, transferred, within
from ovman_engine.bodies.passage import DEEPER_M
from ovman_engine.plan.facing import open_yaw, seen_yaw
from ovman_engine.plan.floorplan import Box, FloorPlan, SimObject
from ovman_engine.room.building import room_of
from ovman_engine.shapes import collision, compound
from ovman_engine.shapes.built_in import is_angled_desk

PASSABLE = frozenset(
    ["Floor", "Window", "Curtains", "Blinds", "Painting", "LightSwitch", "Mirror", "Poster", "Doorway", "Doorframe"]
)
"""Types whose boxes do not block the agent: they hang on a wall, lie under its feet, or are walked through. A shut door has a
wall behind it."""
WIDE_COUNTER_M = 1.2
"""A counter whose box is wider than this both ways is L- or U-shaped, and the agent can stand in the opening."""
SLENDER = frozenset(["Toilet", "HousePlant"])
"""Types whose boxes are mostly empty: a toilet is a bowl on a foot in front of a tank, a plant is leaves above a pot."""
ROUND = frozenset(["DiningTable", "Stool", "GarbageCan", "FloorLamp", "BasketBall"])
"""Types that may be round, so that the corners of their boxes are empty. Recorded agents come no nearer to lower round tables."""
REVOLVED = frozenset(["cylinder", "lathe", "frustum", "ellipsoid"])
"""Kinds of parts with a round outline."""
STAIRS_DEG = (12.0, 30.0, 48.0, 66.0, 80.0)
"""A round outline is that of rectangles in it whose corners are at these angles."""
ROUNDNESS_M = 0.02
"""A round part that comes so near to the sides of its object's box is the outline of the object."""
SQUARE = 1 - 1e-6
"""Cosine above which an axis counts as upright."""
KEPT = 4
"""Number of floor plans that are cached."""

_settings: OrderedDict[int, StaticScene] = OrderedDict()


class StaticScene:
    """The unchanging part of a world."""

    def __init__(self, plan: FloorPlan) -> None:
        """Use `of`, which caches."""
        self.plan = plan
        self.room = room_of(plan)
        self.walls = Boxes.of([w.box for w in self.room.walls])
        self.carriers = carriers(plan)
        self._clearances: dict[Embodiment, dict[str, np.ndarray]] = {}
        self._compounds: dict[tuple[str, ...], tuple] = {}
        self._hollow = {o.object_id: _pieces(o, plan) for o in plan.objects if _is_hollow(o, plan)}
        self._hollow |= {o.object_id: _stairs(o) for o in plan.objects if _is_round(o, plan)}

    @staticmethod
    def of(plan: FloorPlan) -> StaticScene:
        """Return the static scene of `plan`, cached for the last few plans."""
        found = _settings.get(id(plan))
        if found is None or found.plan is not plan:
            found = _settings[id(plan)] = StaticScene(plan)
        _settings.move_to_end(id(plan))
        while len(_settings) > KEPT:
            _settings.popitem(last=False)
        return found

    def barriers(self, obj: SimObject, box: Box) -> list[Box]:
        """Return the boxes of an object that block the agent if its oriented box is `box`.

        They are the box itself, those of the pieces in a mostly empty box, or those that a round outline holds.
        """
        pieces = self._hollow.get(obj.object_id)
        return [box] if pieces is None else within(box, pieces)

    def clearances(self, embodiment: Embodiment) -> Mapping[str, np.ndarray]:
        """Return the clearances that an agent keeps from walls and from the barriers of untouched objects.

        Metres, one for each barrier, by wall name and objectId.

        AI2-THOR's agent stood at the recorded start. So a box that its capsule would overlap there gets a smaller clearance.
        """
        if embodiment not in self._clearances:
            self._clearances[embodiment] = self._measured(embodiment)
        return self._clearances[embodiment]

    def _measured(self, embodiment: Embodiment) -> dict[str, np.ndarray]:
        solids = {w.name: [w.box] for w in self.room.walls}
        solids |= {o.object_id: self.barriers(o, o.box) for o in self.plan.objects if o.type not in PASSABLE}
        low, high = embodiment.axis(float(self.plan.start[1]) + embodiment.foot_m)
        reach = embodiment.radius_m
        boxes = Boxes.of([box for own in solids.values() for box in own])
        at_start = boxes.distances(self.plan.start[None, [0, 2]], low, high, reach)[0]
        allowed = np.where(at_start < reach, np.maximum(at_start - DEEPER_M, 0.0), reach)
        ends = np.cumsum([len(own) for own in solids.values()])
        return dict(zip(solids, np.split(allowed, ends[:-1]) if solids else (), strict=True))

    @cached_property
    def start_yaw_deg(self) -> float:
        """Yaw of the agent at the start: the one that the recorded visible objects tell, else towards the open room."""
        told = seen_yaw(self.plan)
        if told is not None:
            return told
        eye = self.plan.start + [0.0, DEFAULT.camera_m(standing=True), 0.0]
        solid = [o.box for o in self.plan.objects if o.type != "Floor"]
        return open_yaw(eye, [*solid, *(w.box for w in self.room.walls)])

    @cached_property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner of the untouched scene, metres."""
        boxes = [o.box.bounds() for o in self.plan.objects]
        low, high = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
        high = np.maximum(high, [high[0], self.room.ceiling_y, high[2]])
        for corner in (low, high):
            corner.setflags(write=False)
        return low, high

    @cached_property
    def pieces(self) -> Mapping[str, tuple]:
        """Convex pieces of every object, by objectId, in the frames of their boxes."""
        return {o.object_id: _pieces(o, self.plan) for o in self.plan.objects}

    def pieces_with(self, obj: SimObject, parts: Sequence[SimObject]) -> tuple:
        """Convex pieces of an object with these parts and with feet, in the frame of its box. Equal ones are one object."""
        key = (obj.object_id, *(part.object_id for part in parts))
        if key not in self._compounds:
            own = list(self.pieces[obj.object_id])
            for part in parts:
                own += transferred(self.pieces[part.object_id], part.box, obj.box)
            # A bed stands on its headboard too. Without feet of its own, its frame would tip.
            raised = own if self.plan.house is None or obj.type != "Bed" else [p for p in own if not _reaches_floor(p, obj)]
            self._compounds[key] = (*own, *feet(raised, obj.box.half))
        return self._compounds[key]


def _pieces(obj: SimObject, plan: FloorPlan) -> tuple:
    return tuple(piece for part in compound(obj, plan) for piece in collision(part))


def _reaches_floor(piece: tuple, obj: SimObject) -> bool:
    centre, half, rotation = extent(piece)
    return bool(centre[1] - (np.abs(rotation) @ half)[1] < FOOT_M - obj.box.half[1])


def _is_hollow(obj: SimObject, plan: FloorPlan) -> bool:
    low, high = obj.box.bounds()
    wide_counter = obj.type == "CounterTop" and min((high - low)[[0, 2]]) > WIDE_COUNTER_M
    return obj.type in SLENDER or wide_counter or is_angled_desk(obj, plan)


def _is_round(obj: SimObject, plan: FloorPlan) -> bool:
    """Whether the object is drawn with a round outline."""
    if obj.type not in ROUND:
        return False
    half = obj.box.half[[0, 2]]
    parts = (p for p in compound(obj, plan) if p.kind in REVOLVED and p.solid and abs(p.rotation[1, 1]) > SQUARE)
    return any(np.abs(p.size[[0, 2]] / 2 - half).max() < ROUNDNESS_M for p in parts)


def _stairs(obj: SimObject) -> tuple:
    """Boxes within the elliptic outline of an object, as pieces in the frame of its box."""
    angles = np.radians(STAIRS_DEG)
    steps = np.stack([np.cos(angles), np.ones(len(angles)), np.sin(angles)], axis=1)
    return tuple(("box", np.zeros(3), obj.box.half * step, np.eye(3)) for step in steps)
