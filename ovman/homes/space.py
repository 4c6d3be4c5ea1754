"""The floor of a home while it is furnished: what stands where, what has to stay free, and where a robot still gets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from ovman.homes.shell import Rect, Room, Shell

LATTICE_MM = 250
"""Spacing of the navigation grid. Its points have coordinates that are multiples of it."""
BODY_MM = (195, 212)
"""Distances of a robot's centre from walls and things where it stands and where it moves: AI2-THOR's keeps 200 and 210 mm."""
WALL_MM = 25
"""How far a wall stands out into a room"""
CELLS = 12
"""Least number of points of the grid in a room"""


class Footprint(NamedTuple):
    """The floor under a box of `width` and `depth` whose middle is at (x, z), millimetres, turned by `yaw_deg`."""

    x: int
    z: int
    width: int
    depth: int
    yaw_deg: int

    @property
    def rect(self) -> Rect:
        """The rectangle around it."""
        if self.yaw_deg % 90 == 0:
            width, depth = (self.width, self.depth) if self.yaw_deg % 180 == 0 else (self.depth, self.width)
        else:
            sine, cosine = abs(math.sin(math.radians(self.yaw_deg))), abs(math.cos(math.radians(self.yaw_deg)))
            width = 2 * math.ceil((self.width * cosine + self.depth * sine) / 2)
            depth = 2 * math.ceil((self.width * sine + self.depth * cosine) / 2)
        return Rect(self.x - width // 2, self.z - depth // 2, self.x + width // 2, self.z + depth // 2)

    def distances(self, x: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return the squared distances (I, K) of the points (x[i], z[k]) from it, square millimetres."""
        dx, dz = x[:, None] - self.x, z[None, :] - self.z
        angle = math.radians(self.yaw_deg)
        sine, cosine = (round(f(angle), 12) for f in (math.sin, math.cos))
        across = np.maximum(np.abs(dx * cosine - dz * sine) - self.width / 2, 0)
        along = np.maximum(np.abs(dx * sine + dz * cosine) - self.depth / 2, 0)
        return np.asarray(across**2 + along**2)


class Space:
    """Things on the floor, rectangles that stay free, and the points of the grid at which a robot can stand."""

    def __init__(self, shell: Shell) -> None:
        """Make the empty floor."""
        self.rooms = shell.rooms
        self.covered: list[Rect] = []
        self.clear = list(shell.clear)
        """No thing may cover these"""
        high_x = max(room.box.x1 for room in self.rooms)
        high_z = max(room.box.z1 for room in self.rooms)
        self._free = np.zeros((2, high_x // LATTICE_MM + 1, high_z // LATTICE_MM + 1), dtype=bool)
        for free, body in zip(self._free, BODY_MM, strict=True):
            for room in self.rooms:
                inside = np.zeros_like(free)
                inside[self._points(room.box.grown(-body - WALL_MM))] = True
                if room.notch is not None:
                    inside[self._points(room.notch.grown(body + WALL_MM))] = False
                free |= inside
            for way in shell.ways:
                free[self._points(way)] = True

    def _points(self, rect: Rect) -> tuple[slice, slice]:
        """Return the points of the grid that are in a rectangle."""
        spans = []
        for low, high, size in zip(rect[:2], rect[2:], self._free.shape[1:], strict=True):
            first = min(max(-(-low // LATTICE_MM), 0), size)
            spans.append(slice(first, min(max(high // LATTICE_MM + 1, first), size)))
        return spans[0], spans[1]

    def fits(self, prints: Sequence[Footprint], room: Room, gap: int) -> bool:
        """Whether things can stand here: in the room, `gap` from others, not where the floor stays free, in nobody's way."""
        rects = [print_.rect for print_ in prints]
        if not all(room.contains(rect.grown(WALL_MM + 5)) for rect in rects):
            return False
        if any(a.grown(gap).meets(b) for a in rects for b in self.covered) or any(a.meets(b) for a in rects for b in self.clear):
            return False
        free = self._without(prints)
        if any(ndimage.label(one)[1] != 1 for one in free):
            return False
        return all(free[1][self._points(room.box)].sum() >= CELLS for room in self.rooms)

    def _without(self, prints: Iterable[Footprint]) -> np.ndarray:
        """Return the points that are left when things stand here."""
        free = self._free.copy()
        for print_ in prints:
            near = self._points(print_.rect.grown(max(BODY_MM)))
            x, z = (np.arange(s.start, s.stop) * LATTICE_MM for s in near)
            distances = print_.distances(x, z)
            for one, body in zip(free, BODY_MM, strict=True):
                one[near] &= distances >= body**2
        return free

    def cover(self, prints: Sequence[Footprint]) -> None:
        """Record things that stand here from now on."""
        self.covered += [print_.rect for print_ in prints]
        self._free = self._without(prints)

    def share(self, room: Room) -> float:
        """Return the floor on which a robot can stand, as a share of the floor of the room."""
        return float(self._free[1][self._points(room.box)].sum()) * (LATTICE_MM / 1000) ** 2 / room.area_m2

    def find_widest(self, room: Room) -> tuple[int, int]:
        """Return the point of the grid in a room that is farthest from things and from floor that stays free."""
        inside = np.zeros_like(self._free[1])
        inside[self._points(room.box)] = True
        points = np.argwhere(self._free[1] & inside) * LATTICE_MM
        rects = np.array([*self.covered, *self.clear])
        low, high = rects[None, :, :2] - points[:, None], points[:, None] - rects[None, :, 2:]
        x, z = points[int(np.maximum(low, high).max(axis=2).min(axis=1).argmax())]
        return int(x), int(z)
