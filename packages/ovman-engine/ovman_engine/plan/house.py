"""A house as ProcTHOR describes it: rooms, walls, doors, windows and objects.

World frame as in `floorplan`; plan points are (x, z), metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ovman_engine.plan.assets import Asset

LEAST_SIDE_M = 1e-3
STEP_M = 0.1
"""Width of the steps that stand for a slanting side of a floor."""
BESIDE_M = 0.05
"""What is this far from a wall's line is in the room beside it."""


@dataclass(frozen=True)
class Storey:
    """A room. `polygon` (N, 2): its floor, in either sense."""

    name: str
    kind: str
    polygon: np.ndarray
    floor_material: str

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Which plan points (..., 2) lie in the room: (...) bool."""
        inside = np.zeros(points.shape[:-1], dtype=bool)
        for (x_0, z_0), (x_1, z_1) in zip(self.polygon, np.roll(self.polygon, -1, axis=0), strict=True):
            if z_0 != z_1:
                crosses = (z_0 > points[..., 1]) != (z_1 > points[..., 1])
                inside ^= crosses & (points[..., 0] < x_0 + (points[..., 1] - z_0) * (x_1 - x_0) / (z_1 - z_0))
        return inside


@dataclass(frozen=True)
class Sheet:
    """A side of a wall: it runs from `start` to `end` (2,), from height `bottom` to `top`."""

    name: str
    room: str
    start: np.ndarray
    end: np.ndarray
    bottom: float
    top: float
    paint: str
    """Names its material or colour"""
    colour: tuple[float, float, float] | None
    """sRGB, 0 to 1, if the house gives it"""
    empty: bool
    """Whether nothing is there: rooms that are open to each other"""

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.start))

    @property
    def along(self) -> np.ndarray:
        """(2,) unit."""
        return (self.end - self.start) / self.length


@dataclass(frozen=True)
class Opening:
    """A door or a window: `low` and `high` are (2,) distance along its first wall and height."""

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
        """Whether an agent can go through: no window, no way out of the house, and not shut."""
        return not self.window and len(set(self.rooms)) > 1 and (self.openness > 0 or not self.openable)


@dataclass(frozen=True)
class Furnishing:
    """An object: the middle of its box, Euler angles in degrees, and whose box it is in or on."""

    name: str
    asset: Asset
    position: np.ndarray
    rotation: np.ndarray
    kinematic: bool
    openness: float
    parent: str | None


@dataclass(frozen=True)
class House:
    """All of a house. `agent`: position (3,), yaw and horizon in degrees, standing, where the house says so."""

    name: str
    rooms: tuple[Storey, ...]
    walls: tuple[Sheet, ...]
    openings: tuple[Opening, ...]
    objects: tuple[Furnishing, ...]
    agent: tuple[np.ndarray, float, float, bool] | None

    @cached_property
    def height(self) -> float:
        """Of the highest wall's top, metres."""
        return max((w.top for w in self.walls), default=3.0)


def side(sheet: Sheet, house: House) -> float:
    """1 if the sheet is seen from the left of its line, else -1: a room's from the room, an outer one from outside."""
    middle = (sheet.start + sheet.end) / 2
    left = middle + np.array([-sheet.along[1], sheet.along[0]]) * BESIDE_M
    inside = [r for r in house.rooms if bool(r.contains(left))]
    if "exterior" in sheet.name:
        return -1.0 if inside else 1.0
    return (
        1.0 if any(r.name == sheet.room for r in inside) or (inside and sheet.room not in {r.name for r in house.rooms}) else -1.0
    )


def rectangles(room: Storey) -> list[tuple[float, float, float, float]]:
    """The room's floor as rectangles (x from, x to, z from, z to), each with an area; slanting sides become steps.

    A part of the polygon that another part covers again is outside (even-odd rule), as in `Storey.contains`.
    """
    xs = np.unique(np.round(room.polygon[:, 0], 4))
    if not _straight(room):
        xs = np.unique(np.concatenate([xs, np.arange(xs[0], xs[-1], 0.1)]))
    out = []
    for a, b in zip(xs[:-1], xs[1:], strict=True):
        if b - a <= LEAST_SIDE_M:
            continue
        ends = _crossings(room.polygon, (a + b) / 2)
        spans = zip(ends[::2], ends[1::2], strict=False)
        out += [(float(a), float(b), float(c), float(d)) for c, d in spans if d > c]
    return out


def _straight(room: Storey) -> bool:
    edges = np.roll(room.polygon, -1, axis=0) - room.polygon
    return bool((np.abs(edges).min(axis=1) < LEAST_SIDE_M).all())


def _crossings(polygon: np.ndarray, x: float) -> list[float]:
    """Where the line of constant `x` crosses the polygon's sides, in order."""
    out = []
    for (x_0, z_0), (x_1, z_1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if (x_0 > x) != (x_1 > x):
            out.append(z_0 + (x - x_0) * (z_1 - z_0) / (x_1 - x_0))
    return sorted(out)


def empty(half_m: float = 5.0) -> House:
    """A floor without walls: the scene that a house is put into."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float) * half_m
    return House("Procedural", (Storey("Floor|+00.00|+00.00|+00.00", "", square, ""),), (), (), (), None)
