"""Dead reckoning: the pose as the sum of the commanded motions. Errors of the body go unnoticed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ovman.agents.interface import Action


@dataclass(frozen=True, slots=True)
class Pose:
    """A believed position and heading in the frame of the episode's start; x, z in metres, yaw in degrees in [0, 360)."""

    x: float = 0.0
    z: float = 0.0
    yaw_deg: float = 0.0

    def after(self, action: Action, step_m: float, turn_deg: float) -> Pose:
        """The pose after `action` without error; unchanged for an action that is no motion."""
        if action is Action.MOVE_AHEAD:
            yaw = math.radians(self.yaw_deg)
            return Pose(self.x + step_m * math.sin(yaw), self.z + step_m * math.cos(yaw), self.yaw_deg)
        if action is Action.ROTATE_RIGHT:
            return Pose(self.x, self.z, (self.yaw_deg + turn_deg) % 360.0)
        if action is Action.ROTATE_LEFT:
            return Pose(self.x, self.z, (self.yaw_deg - turn_deg) % 360.0)
        return self

    def cell(self, voxel_m: float) -> tuple[int, int]:
        """The voxel of the agent, truncated towards the start."""
        return int(self.x / voxel_m), int(self.z / voxel_m)


def failed(before: np.ndarray, now: np.ndarray, unchanged_m: float) -> bool:
    """Whether the action between two depth images (H, W), metres, seems to have failed.

    It does if mean and standard deviation of the absolute change are both below `unchanged_m`.
    """
    change = np.abs(now - before)
    return bool(change.mean() < unchanged_m and change.std() < unchanged_m)
