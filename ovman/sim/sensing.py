"""What sensors that err make of depths and poses. Pure: all draws come from a seed.

Depth is as noisy as that of the RGB-D camera that Nguyen, Izadi and Lovell measured ("Modeling Kinect sensor noise for
improved 3D reconstruction and tracking", 3DIMPVT 2012): axial noise grows with the square of the distance. Poses come from an
odometry whose increments err, as in Thrun, Burgard and Fox, "Probabilistic Robotics", section 5.4: what was turned wrongly
bends the way gone after it. Nobody who judges reads a sensed pose.
"""

from __future__ import annotations

import math

import numpy as np

from ovman.records.record import DEGREE_DECIMALS, METRE_DECIMALS
from ovman.records.tour import Sensors
from ovman.sim.session import AgentPose

FARTHEST_M = 65.535
"""Largest depth that a recording holds, metres."""


class Sensing:
    """The sensors of one visit or run. Calls must follow the order of events.

    begin: called with the first pose; `pose` then follows the agent. The true pose goes in, the sensed one comes out.
    """

    def __init__(self, sensors: Sensors) -> None:
        self._errors = sensors.errors
        # One stream each, so that an agent that is given no depth gets the same poses.
        self._poses, self._depths = (np.random.default_rng(seq) for seq in np.random.SeedSequence(sensors.seed).spawn(2))
        self._true: AgentPose | None = None
        self._sensed = AgentPose(0.0, 0.0, 0.0)

    def pose(self, true: AgentPose) -> AgentPose:
        """Return the sensed pose of an agent that is now at `true`, and has come there from the pose of the last call.

        Nothing errs further where nothing was done since. The horizon is exact.
        """
        errors, here = self._errors, AgentPose(true.x, true.z, true.yaw_deg)
        if self._true is None:
            dx, dz, turn = self._poses.normal(0.0, 1.0, 3)
            self._sensed = AgentPose(
                here.x + errors.pose_m * dx, here.z + errors.pose_m * dz, here.yaw_deg + errors.pose_deg * turn
            )
        elif here != self._true:
            self._sensed = self._moved(self._true, here)
        self._true = here
        sensed = self._sensed
        return AgentPose(
            round(sensed.x, METRE_DECIMALS),
            round(sensed.z, METRE_DECIMALS),
            round(sensed.yaw_deg % 360.0, DEGREE_DECIMALS) % 360.0,
            true.horizon_deg,
        )

    def _moved(self, before: AgentPose, here: AgentPose) -> AgentPose:
        dx, dz = here.x - before.x, here.z - before.z
        gone_m, turned_deg = math.hypot(dx, dz), (here.yaw_deg - before.yaw_deg + 180.0) % 360.0 - 180.0
        along, across, turn = self._poses.normal(0.0, 1.0, 3)
        # The way gone, seen from the true pose, is laid on from the sensed one.
        x, z = _turned(dx, dz, self._sensed.yaw_deg - before.yaw_deg)
        spread_m = self._errors.drift_m * math.sqrt(gone_m)
        spread_deg = self._errors.drift_deg * math.sqrt(gone_m + abs(turned_deg) / 360.0)
        return AgentPose(
            self._sensed.x + x + spread_m * along,
            self._sensed.z + z + spread_m * across,
            self._sensed.yaw_deg + turned_deg + spread_deg * turn,
        )

    def depth(self, true: np.ndarray) -> np.ndarray:
        """Return the sensed depth (H, W) float32, metres, of a true one; where nothing has a depth (0) there is none either."""
        errors = self._errors
        beyond = true.astype(np.float64) - errors.depth_nearest_m
        spread = errors.depth_m + errors.depth_per_m2 * np.square(beyond)
        noisy = true + spread * self._depths.standard_normal(true.shape)
        found: np.ndarray = np.where(true > 0, np.clip(noisy, 0.001, FARTHEST_M), 0.0).astype(np.float32)
        return found


def placed(camera: tuple[float, float, float], true: AgentPose, sensed: AgentPose) -> tuple[float, float, float]:
    """Return the camera's place (x, y, z), metres, for an agent that is at `true` and takes itself to be at `sensed`."""
    x, z = _turned(camera[0] - true.x, camera[2] - true.z, sensed.yaw_deg - true.yaw_deg)
    return round(sensed.x + x, METRE_DECIMALS), camera[1], round(sensed.z + z, METRE_DECIMALS)


def _turned(x: float, z: float, turn_deg: float) -> tuple[float, float]:
    bent = math.radians(turn_deg)
    return math.cos(bent) * x + math.sin(bent) * z, math.cos(bent) * z - math.sin(bent) * x
