"""The room around the objects: its outline from the evidence in a floor plan, and what of it bounds agent and bodies.

Floor plans record no walls. The recorded floor is a rectangle that is too large in half of the scenes, but paintings, windows,
mirrors and switches hang on walls. So the room is the floor rectangle, drawn in by a margin and by what else there is, and cut
back to every wall that something hangs on. World frame as in `floorplan`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ovman.engine.floorplan import Box, FloorPlan

FLOOR_MARGIN_M = 0.45
"""How far inside the recorded floor rectangle its walls stand, where nothing says otherwise; fitted to recorded reachable grids."""
WALL_ITEMS = frozenset(
    ["Window", "Painting", "LightSwitch", "Mirror", "Blinds", "Poster", "Curtains", "HandTowelHolder", "TowelHolder", "ToiletPaperHanger"]
)
"""Types that hang flat on a wall."""
THIN_M = 0.2
"""A wall item thicker than this does not tell where its wall is."""
BESIDE_M = 0.3
"""How far to both sides of a wall item its wall goes on for certain."""
SLAB_M = 3.0
"""Depth of the solid behind a wall's face: nothing passes at any speed that physics allows."""

BEYOND_M = 0.02
"""Distance of the shell from everything."""


@dataclass(frozen=True)
class Wall:
    """A solid with a vertical face towards the room."""

    name: str
    box: Box


@dataclass(frozen=True)
class Room:
    """What bounds a floor plan."""

    plan: FloorPlan
    rectangle: tuple[float, float, float, float]
    """(x_0, z_0, x_1, z_1) metres: no wall stands outside it"""
    walls: tuple[Wall, ...]
    shell: tuple[Wall, ...]
    """Solids around everything that the plan holds: what stands in a wall from the beginning stays inside these"""
    ceiling_y: float

    @property
    def floor_y(self) -> float:
        return self.plan.floor_y

    @staticmethod
    def of(plan: FloorPlan) -> Room:
        """The room of `plan`."""
        rectangle = _rectangle(plan)
        ceiling_y = _ceiling(plan)
        low, high = plan.floor_y - 1.0, ceiling_y + 1.0
        walls = [_wall(*sides, low, high) for sides in (*_around(rectangle), *_behind(plan, rectangle))]
        bounds = [o.box.bounds() for o in plan.objects]
        least, most = np.min([b[0] for b in bounds], axis=0) - BEYOND_M, np.max([b[1] for b in bounds], axis=0) + BEYOND_M
        shell = [_wall(*sides, low, high) for sides in _around((least[0], least[2], most[0], most[2]))]
        return Room(plan, rectangle, tuple(walls), tuple(shell), ceiling_y)

    def parts(self) -> tuple[tuple[str, tuple[Any, ...], Mapping[str, Any]], ...]:
        """(structure name, parts in the world frame, palette) of walls and ceiling."""
        from ovman.engine.materials import Material
        from ovman.engine.shapes.part import Part

        paint = {"main": Material(np.array([0.7, 0.68, 0.64]))}
        x_0, z_0, x_1, z_1 = self.rectangle
        top, bottom, t = self.ceiling_y, self.floor_y - 0.05, 0.1
        slabs = [
            ((x_0 - t, bottom, z_0 - t), (x_0, top, z_1 + t)),
            ((x_1, bottom, z_0 - t), (x_1 + t, top, z_1 + t)),
            ((x_0, bottom, z_0 - t), (x_1, top, z_0)),
            ((x_0, bottom, z_1), (x_1, top, z_1 + t)),
        ]
        out = []
        for kind, (low, high) in [("wall", s) for s in slabs] + [
            ("ceiling", ((x_0 - t, top, z_0 - t), (x_1 + t, top + t, z_1 + t)))
        ]:
            low, high = np.array(low), np.array(high)
            out.append((structure_name(kind, (low + high) / 2), (Part("box", (low + high) / 2, high - low),), paint))
        return tuple(out)


def _around(rectangle: tuple[float, float, float, float]) -> list[tuple[float, float, float, float]]:
    x_0, z_0, x_1, z_1 = rectangle
    return [
        (x_0 - SLAB_M, z_0 - SLAB_M, x_0, z_1 + SLAB_M),
        (x_1, z_0 - SLAB_M, x_1 + SLAB_M, z_1 + SLAB_M),
        (x_0 - SLAB_M, z_0 - SLAB_M, x_1 + SLAB_M, z_0),
        (x_0 - SLAB_M, z_1, x_1 + SLAB_M, z_1 + SLAB_M),
    ]


def structure_name(kind: str, centre: np.ndarray) -> str:
    """Name of a structure as AI2-THOR writes it: kind|x|y|z."""
    return kind + "".join(f"|{value:+06.2f}" for value in centre)


def _wall(x_0: float, z_0: float, x_1: float, z_1: float, low: float, high: float) -> Wall:
    centre = np.array([(x_0 + x_1) / 2, (low + high) / 2, (z_0 + z_1) / 2])
    half = np.array([x_1 - x_0, high - low, z_1 - z_0]) / 2
    return Wall(structure_name("wall", centre), Box(centre, half, np.eye(3)))


def _rectangle(plan: FloorPlan) -> tuple[float, float, float, float]:
    floor = plan.floor.box.bounds()
    others = [o.box.bounds() for o in plan.objects if o.type != "Floor"]
    low = np.maximum(floor[0] + FLOOR_MARGIN_M, np.min([b[0] for b in others], axis=0))
    high = np.minimum(floor[1] - FLOOR_MARGIN_M, np.max([b[1] for b in others], axis=0))
    return float(low[0]), float(low[2]), float(high[0]), float(high[2])


def _ceiling(plan: FloorPlan) -> float:
    tops = [o.box.bounds()[1][1] for o in plan.objects if o.type != "Floor"]
    return plan.floor_y + float(np.clip(max(tops) - plan.floor_y + 0.1, 2.5, 3.0))


def _behind(plan: FloorPlan, rectangle: tuple[float, float, float, float]) -> list[tuple[float, float, float, float]]:
    """Plan rectangles behind the wall items: from each item's plane to beyond the nearer side of the floor."""
    floor_low, floor_high = (corner[[0, 2]] for corner in plan.floor.box.bounds())
    start = plan.start[[0, 2]]
    out = []
    for item in plan.objects:
        if item.type not in WALL_ITEMS:
            continue
        low, high = (corner[[0, 2]] for corner in item.box.bounds())
        size = high - low
        thin = int(np.argmin(size))
        if size[thin] >= THIN_M or size[thin] >= size[1 - thin]:
            continue
        plane = (low[thin] + high[thin]) / 2
        first, last = np.zeros(2), np.zeros(2)
        first[1 - thin], last[1 - thin] = low[1 - thin] - BESIDE_M, high[1 - thin] + BESIDE_M
        if abs(plane - floor_low[thin]) < abs(plane - floor_high[thin]):
            first[thin], last[thin] = floor_low[thin] - SLAB_M, plane
        else:
            first[thin], last[thin] = plane, floor_high[thin] + SLAB_M
        if not ((start >= first) & (start <= last)).all():
            out.append((float(first[0]), float(first[1]), float(last[0]), float(last[1])))
    return out
