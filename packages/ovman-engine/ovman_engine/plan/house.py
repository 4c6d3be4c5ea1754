"""A house as ProcTHOR describes it: rooms, walls, doors, windows and objects.

World frame as in `floorplan`; plan points are (x, z), metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ovman_engine.plan.assets import Asset

MIN_SIDE_M = 1e-3
STEP_M = 0.1
"""Width of the steps that approximate slanting sides of a floor."""
BESIDE_M = 0.05
"""A point this far from the line of a wall is in the room beside it."""


@dataclass(frozen=True)
class HouseRoom:
    """A room. `polygon` (N, 2) is its floor, in either orientation."""

    name: str
    kind: str
    polygon: np.ndarray
    floor_material: str

    def contains(self, points: np.ndarray) -> np.ndarray:
        """(...) bool: which plan points (..., 2) are in the room, by the even-odd rule."""
        inside = np.zeros(points.shape[:-1], dtype=bool)
        for (x_0, z_0), (x_1, z_1) in zip(self.polygon, np.roll(self.polygon, -1, axis=0), strict=True):
            if z_0 != z_1:
                crosses = (z_0 > points[..., 1]) != (z_1 > points[..., 1])
                inside ^= crosses & (points[..., 0] < x_0 + (points[..., 1] - z_0) * (x_1 - x_0) / (z_1 - z_0))
        return inside


@dataclass(frozen=True)
class WallSide:
    """One side of a wall, from `start` to `end` (2,), and from height `bottom` to `top`, metres."""

    name: str
    room: str
    start: np.ndarray
    end: np.ndarray
    bottom: float
    top: float
    paint: str
    """Name of its material"""
    colour: tuple[float, float, float] | None
    """sRGB, 0 to 1; None if the house gives no colour"""
    empty: bool
    """Whether the wall is only a border between rooms that are open to each other"""

    @property
    def length(self) -> float:
        """Length in plan, metres."""
        return float(np.linalg.norm(self.end - self.start))

    @property
    def along(self) -> np.ndarray:
        """Unit vector (2,) from start to end."""
        return (self.end - self.start) / self.length


@dataclass(frozen=True)
class Opening:
    """A door or a window. `low` and `high` (2,) are distances along its first wall and heights, metres."""

    name: str
    asset_id: str
    walls: tuple[str, ...]
    rooms: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray
    openable: bool
    openness: float
    window: bool

    @property
    def passable(self) -> bool:
        """Whether an agent can pass: a door inside the house that is not shut."""
        return not self.window and len(set(self.rooms)) > 1 and (self.openness > 0 or not self.openable)


@dataclass(frozen=True)
class Furnishing:
    """An object of the house: centre (3,) of its box, Euler angles (3,) in degrees, and the id of the object that holds it."""

    name: str
    asset: Asset
    position: np.ndarray
    rotation: np.ndarray
    kinematic: bool
    openness: float
    parent: str | None


@dataclass(frozen=True)
class House:
    """A house. `agent` is its start, if given: position (3,), yaw and horizon in degrees, standing."""

    name: str
    rooms: tuple[HouseRoom, ...]
    walls: tuple[WallSide, ...]
    openings: tuple[Opening, ...]
    objects: tuple[Furnishing, ...]
    agent: tuple[np.ndarray, float, float, bool] | None

    @cached_property
    def height(self) -> float:
        """Height of the highest wall, metres."""
        return max((w.top for w in self.walls), default=3.0)


def side(sheet: WallSide, house: House) -> float:
    """1 if the side is seen from the left of its line, else -1: from its room, or from outside for an exterior wall."""
    middle = (sheet.start + sheet.end) / 2
    left = middle + np.array([-sheet.along[1], sheet.along[0]]) * BESIDE_M
    inside = [r for r in house.rooms if bool(r.contains(left))]
    if "exterior" in sheet.name:
        return -1.0 if inside else 1.0
    return (
        1.0 if any(r.name == sheet.room for r in inside) or (inside and sheet.room not in {r.name for r in house.rooms}) else -1.0
    )


def rectangles(room: HouseRoom) -> list[tuple[float, float, float, float]]:
    """Return the room's floor as rectangles (x from, x to, z from, z to), each with an area; slanting sides become steps.

    A part of the polygon that another part covers again is outside (even-odd rule), as in `HouseRoom.contains`.
    """
    xs = np.unique(np.round(room.polygon[:, 0], 4))
    if not _straight(room):
        xs = np.unique(np.concatenate([xs, np.arange(xs[0], xs[-1], 0.1)]))
    out = []
    for a, b in zip(xs[:-1], xs[1:], strict=True):
        if b - a <= MIN_SIDE_M:
            continue
        ends = _crossings(room.polygon, (a + b) / 2)
        spans = zip(ends[::2], ends[1::2], strict=False)
        out += [(float(a), float(b), float(c), float(d)) for c, d in spans if d > c]
    return out


def largest_rectangle(room: HouseRoom) -> tuple[float, float, float, float]:
    """Return the largest of a room's `rectangles`: (x from, x to, z from, z to)."""
    return max(rectangles(room), key=lambda r: (r[1] - r[0]) * (r[3] - r[2]))


def _straight(room: HouseRoom) -> bool:
    edges = np.roll(room.polygon, -1, axis=0) - room.polygon
    return bool((np.abs(edges).min(axis=1) < MIN_SIDE_M).all())


def _crossings(polygon: np.ndarray, x: float) -> list[float]:
    """Sorted z at which the line of constant `x` crosses the sides of the polygon."""
    out = []
    for (x_0, z_0), (x_1, z_1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if (x_0 > x) != (x_1 > x):
            out.append(z_0 + (x - x_0) * (z_1 - z_0) / (x_1 - x_0))
    return sorted(out)


def empty(half_m: float = 5.0) -> House:
    """Return a floor without walls: the scene that CreateHouse replaces."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float) * half_m
    return House("Procedural", (HouseRoom("Floor|+00.00|+00.00|+00.00", "", square, ""),), (), (), (), None)
