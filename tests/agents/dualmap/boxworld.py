"""Boxes in a room, and what a camera on a walk among them shows: observations made from the boxes alone, without pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ovman.agents.dualmap.observations import FrameObject
from tests.arms import CONFIG

CONSTANTS = CONFIG.dualmap
FEATURES = 16


@dataclass(frozen=True)
class Box:
    """centre (x, y, z) and size (x, y, z) in metres, Unity's frame."""

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    class_id: int

    def moved(self, x: float, z: float) -> Box:
        return replace(self, centre=(self.centre[0] + x, self.centre[1], self.centre[2] + z))


def feature(class_id: int) -> np.ndarray:
    """(FEATURES,) unit vector of a class; those of different classes are orthogonal."""
    return np.eye(FEATURES, dtype=np.float32)[class_id]


def surface(box: Box, eye: np.ndarray, points: int, rng: np.random.Generator) -> np.ndarray:
    """(points, 3) on those faces of a box that can be seen from `eye`."""
    centre, half = np.array(box.centre), np.array(box.size) / 2
    sides = [(axis, sign) for axis in range(3) for sign in (-1, 1) if sign * (eye[axis] - centre[axis]) > half[axis]]
    areas = np.array([np.prod(np.delete(half, axis)) for axis, _ in sides])
    spots = rng.uniform(-1, 1, (points, 3)) * half
    axis, sign = np.array(sides)[rng.choice(len(sides), points, p=areas / areas.sum())].T
    spots[np.arange(points), axis] = sign * half[axis]
    return (centre + spots).astype(np.float32)


def observation(box: Box, eye: np.ndarray, rng: np.random.Generator, runs: int = 1, points: int = 400) -> FrameObject:
    """What a keyframe shows of a box, in `runs` draws of its points."""
    clouds = tuple(surface(box, eye, points, rng) for _ in range(runs))
    return FrameObject(box.class_id, feature(box.class_id), 0.8, clouds)


def walk(boxes: list[Box], views: list[tuple[float, float, float]], seed: int = 0, runs: int = 1) -> list[list[FrameObject]]:
    """The keyframes of a walk: views (x, z, yaw in degrees) of a camera at 0.9 m with a field of view of 90 degrees."""
    rng = np.random.default_rng(seed)
    frames: list[list[FrameObject]] = []
    for x, z, yaw in views:
        eye, ahead = np.array([x, 0.9, z]), np.array([np.sin(np.radians(yaw)), np.cos(np.radians(yaw))])
        seen = []
        for box in boxes:
            towards = np.array([box.centre[0] - x, box.centre[2] - z])
            if 0.5 < np.linalg.norm(towards) < 5 and towards @ ahead > np.linalg.norm(towards) * np.cos(np.radians(42)):
                seen.append(observation(box, eye, rng, runs))
        frames.append(seen)
    return frames


TEN = [
    Box((x, 0.3, z), (0.5, 0.6, 0.5), class_id=number)
    for number, (x, z) in enumerate([(0, 0), (2, 0), (4, 0), (6, 0), (0, 4), (2, 4), (4, 4), (6, 4), (0, 2), (6, 2)])
]
"""Ten boxes of half a metre around a room of 6 m by 4 m."""

STANDS = [(1.0, 1.0), (1.5, 2.8), (3.0, 2.0), (4.6, 1.0), (5.0, 3.0), (3.0, 3.0)]
TOUR = [(x, z, 90.0 * k) for x, z in STANDS for k in range(4)]
"""Four headings at six places: 24 views."""
DENSE = [(x, z, 30.0 * k) for x, z in STANDS for k in range(12)]
"""Spins in steps of 30 degrees at the same places."""
