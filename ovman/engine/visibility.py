"""Which objects the agent sees: near enough, in the picture, and not hidden behind another object's box.

AI2-THOR casts rays from the camera to points that its artists put on each object; here they go to points spread over the oriented
box, and the boxes of the other objects stand in their way. Boxes are larger than what they hold, so a box that the target
reaches into, or that the camera is in, hides nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.engine.floorplan import Box

CAPSULE_HALF_M = 0.7
"""Half the length of the axis of the agent's capsule: an object is near if it is within the distance from that axis."""
SPREAD = np.array([[x, y, z] for x in (-0.8, 0.0, 0.8) for y in (-0.8, 0.0, 0.8) for z in (-0.8, 0.0, 0.8)])
"""Points of a box that are looked for, in units of its half extents."""


@dataclass(frozen=True)
class Eye:
    """The camera and the agent that carries it."""

    agent: np.ndarray
    """(3,) metres, middle of the agent's capsule"""
    position: np.ndarray
    """(3,) metres, of the camera"""
    yaw_deg: float
    horizon_deg: float
    field_of_view_deg: float
    """vertical"""
    aspect: float
    """width by height"""

    def sees(self, points: np.ndarray) -> np.ndarray:
        """Which of the points (..., 3) lie within the picture: (...) bool."""
        yaw, pitch = math.radians(self.yaw_deg), math.radians(self.horizon_deg)
        sy, cy, sp, cp = math.sin(yaw), math.cos(yaw), math.sin(pitch), math.cos(pitch)
        axes = np.array([[cy, 0.0, -sy], [sy * sp, cp, cy * sp], [sy * cp, -sp, cy * cp]])
        local = (points - self.position) @ axes.T
        reach = local[..., 2] * math.tan(math.radians(self.field_of_view_deg) / 2)
        return (local[..., 2] > 0) & (np.abs(local[..., 1]) <= reach) & (np.abs(local[..., 0]) <= reach * self.aspect)


class Sight:
    """The boxes of N objects in columns (centre (N, 3), half (N, 3), rotation (N, 3, 3)), asked who of them is visible."""

    def __init__(self, boxes: Sequence[Box], there: Sequence[bool], hiding: Sequence[bool]) -> None:
        """Only objects that are `there` are seen, and those of them that are `hiding` hide others."""
        self.centre = np.array([b.centre for b in boxes]).reshape(-1, 3)
        self.half = np.array([b.half for b in boxes]).reshape(-1, 3)
        self.rotation = np.array([b.rotation for b in boxes]).reshape(-1, 3, 3)
        self._there = np.array(there, dtype=bool)
        self._hiding = self._there & np.array(hiding, dtype=bool)
        self._reach = np.linalg.norm(self.half, axis=1)

    def visible(self, eye: Eye, distance_m: float, asked: np.ndarray | None = None) -> np.ndarray:
        """(N,) bool: who is visible, of the objects `asked` for (N,) bool or of all."""
        result = np.zeros(len(self.centre), dtype=bool)
        far = np.linalg.norm(self.centre[:, [0, 2]] - eye.agent[[0, 2]], axis=1)
        near = np.flatnonzero(self._there & (True if asked is None else asked) & (far - self._reach <= distance_m))
        near = near[self._distance(near, eye.agent) <= distance_m]
        if not len(near):
            return result
        points = self.centre[near, None] + np.einsum("nij,nkj->nki", self.rotation[near], SPREAD * self.half[near, None])
        seen = eye.sees(points)
        target, point = np.nonzero(seen)
        if not len(target):
            return result
        others = np.flatnonzero(self._hiding & (far - self._reach <= far[near].max() + self._reach[near].max()))
        free = ~self._hidden(eye.position, points[target, point], near[target], others)
        result[near[target[free]]] = True
        return result

    def _distance(self, which: np.ndarray, agent: np.ndarray) -> np.ndarray:
        """From the axis of the agent's capsule to the boxes (metres); to the nearest of three points on it."""
        heights = agent[1] + np.array([-CAPSULE_HALF_M, 0.0, CAPSULE_HALF_M])
        axis = np.array([[agent[0], y, agent[2]] for y in heights])
        local = np.einsum("nij,nki->nkj", self.rotation[which], axis[None] - self.centre[which, None])
        outside = np.maximum(np.abs(local) - self.half[which, None], 0.0)
        return np.linalg.norm(outside, axis=2).min(axis=1)

    def _hidden(self, camera: np.ndarray, points: np.ndarray, targets: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Whether a box of `others` lies between the camera and each point (R, 3) of the object `targets` (R,): (R,) bool."""
        turn, half = self.rotation[others], self.half[others]
        start = np.einsum("nij,ni->nj", turn, camera - self.centre[others])
        end = np.einsum("nij,rni->rnj", turn, points[:, None] - self.centre[others])
        along = end - start
        with np.errstate(divide="ignore", invalid="ignore"):
            one, two = (-half - start) / along, (half - start) / along
        enter, leave = np.fmin(one, two).max(axis=2), np.fmax(one, two).min(axis=2)
        crossed = (enter < leave) & (enter > 0) & (leave < 1)
        return (crossed & (others[None] != targets[:, None])).any(axis=1)
