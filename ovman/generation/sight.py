"""What a tour is foreseen to record of an instance, from the boxes of a scene alone. Pure geometry, metres.

It judges nothing: of several draws the one is taken in which most is foreseen to be recorded, because tours cost more than draws.
What was recorded is judged on the tours.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.records.geometry import Point
from ovman.records.scene import Scene, SceneObject

EYE_M = 1.576
"""Height of the camera of AI2-THOR's default agent above the floor."""
SAMPLES = np.array([(x, y, z) for x in (-0.8, 0.0, 0.8) for y in (-0.8, 0.0, 0.8) for z in (-0.8, 0.0, 0.8)])
"""Points of a box that are looked at, in half extents from its centre."""
STEEPEST = 0.9
"""What lies steeper than this (height over distance) is above or below a view that looks straight ahead with 90 degrees."""
NOT_IN_THE_WAY = frozenset({"Floor", "Wall", "Ceiling", "Window", "Blinds", "Curtains", "Doorway", "Rug", "Carpet"})
"""Categories whose boxes are as large as the room, or flat on it."""


@dataclass(frozen=True)
class Sight:
    """The view from the waypoints of a tour. eyes: (W, 3); low, high: (B, 3), corners of every box that can occlude.

    find_rooms: `Scene.find_rooms`. Walls have no boxes, so a thing in another room than the eye counts as hidden.
    """

    eyes: np.ndarray
    find_rooms: Callable[[np.ndarray], np.ndarray]
    ids: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray

    @staticmethod
    def of(scene: Scene, waypoints: Sequence[Point]) -> Sight:
        """Return the sight from `waypoints` in the untouched scene."""
        eyes = np.array([(x, scene.floor_y + EYE_M, z) for x, z in waypoints])
        there = [o for o in scene.objects if o.category not in NOT_IN_THE_WAY]
        centre = np.array([tuple(dict(o.position).values()) for o in there]).reshape(-1, 3)
        half = np.array([tuple(dict(o.size).values()) for o in there]).reshape(-1, 3) / 2
        return Sight(eyes, scene.find_rooms, tuple(o.id for o in there), centre - half, centre + half)

    def solid_angle(self, item: SceneObject, centre: tuple[float, float, float]) -> float:
        """Largest solid angle, steradians, under which the box of `item` is seen from a waypoint with its centre at `centre`.

        A box hides what is behind it, but not what is in it.
        """
        half = np.array([item.size.x, item.size.y, item.size.z]) / 2
        points = np.array(centre) + half * SAMPLES
        kept = np.array([k != item.id for k in self.ids], bool)
        low, high = self.low[kept], self.high[kept]
        around = ((low <= centre) & (np.array(centre) <= high)).all(axis=1)
        low, high = low[~around], high[~around]
        found = 0.0
        in_room = self.find_rooms(self.eyes[:, [0, 2]]) == self.find_rooms(np.array(centre)[[0, 2]])
        for eye in self.eyes[in_room]:
            ways = points - eye
            level = np.hypot(ways[:, 0], ways[:, 2])
            seen = np.abs(ways[:, 1]) <= STEEPEST * level
            if seen.any():
                seen[seen] = ~_hidden(eye, ways[seen], low, high)
                found = max(found, float(seen.mean()) * _silhouette(np.array(centre) - eye, half))
        return found


def _silhouette(way: np.ndarray, half: np.ndarray) -> float:
    """Solid angle of a box, steradians, as if it were flat and far away."""
    distance = float(np.linalg.norm(way))
    towards = np.abs(way) / max(distance, 1e-6)
    x, y, z = 2 * half
    return float(towards @ (y * z, x * z, x * y)) / max(distance, 0.3) ** 2


def _hidden(eye: np.ndarray, ways: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(M,) whether a box (B, 3), (B, 3) meets the segment from `eye` along each of `ways` (M, 3); not one that the eye is in."""
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = ((corner[None] - eye) / ways[:, None] for corner in (low, high))
    enters = np.nanmax(np.minimum(one, other), axis=2)
    leaves = np.nanmin(np.maximum(one, other), axis=2)
    hidden: np.ndarray = ((enters < leaves) & (enters > 0.0) & (enters < 1.0)).any(axis=1)
    return hidden
