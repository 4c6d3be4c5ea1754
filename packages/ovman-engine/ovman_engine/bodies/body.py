"""The objects and the agent of a world. World frame as in `floorplan`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ovman_engine.bodies.embodiment import DEFAULT, Embodiment
from ovman_engine.plan.floorplan import Box, SimObject

STAYS_M = 1e-3
"""Tolerance of `Pose.near`: of the pivot, and of the tips of the body's unit axes."""


@dataclass(frozen=True)
class Pose:
    """Position of an object's pivot (3,) metres, and rotation (3, 3) from object to world axes."""

    position: np.ndarray
    rotation: np.ndarray

    def near(self, other: Pose) -> bool:
        """Whether both poses are the same within STAYS_M."""
        moved = np.abs(self.position - other.position).max()
        return bool(moved < STAYS_M and np.abs(self.rotation - other.rotation).max() < STAYS_M)


@dataclass
class Agent:
    """The agent: position (3,) metres, 0.9 m above its feet. A positive horizon looks down."""

    position: np.ndarray
    yaw_deg: float = 0.0
    horizon_deg: float = 0.0
    standing: bool = True
    """Always True for an embodiment that does not crouch"""
    embodiment: Embodiment = DEFAULT

    @property
    def camera(self) -> np.ndarray:
        """Position (3,) of the camera, metres."""
        return self.position + [0.0, self.embodiment.camera_m(self.standing), 0.0]

    @property
    def foot(self) -> float:
        """Height of the lower end of the capsule, metres."""
        return float(self.position[1]) + self.embodiment.foot_m


@dataclass
class Body:
    """An object in its current state."""

    obj: SimObject
    """The object as recorded in the floor plan"""
    object_id: str
    name: str
    pose: Pose
    active: bool = True
    removed: bool = False
    dynamic: bool = False
    kinematic: bool = False
    """Whether the object is fixed: gravity does not move it"""
    carrier: str | None = None
    """objectId of the body that this one is a part of (the dresser of a drawer), and with which it moves"""
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """(6,) linear, then angular velocity, m/s and rad/s, world frame"""

    @staticmethod
    def of(obj: SimObject) -> Body:
        """Return the untouched body of `obj`."""
        return Body(obj, obj.object_id, obj.name, Pose(obj.position, obj.rotation), dynamic=obj.dynamic)

    @property
    def untouched(self) -> bool:
        """Whether the body is at its recorded pose and was never moved."""
        return self.pose.position is self.obj.position and self.pose.rotation is self.obj.rotation

    @property
    def stays(self) -> bool:
        """Whether the body is at its recorded pose, within STAYS_M, moved or not."""
        return self.pose.near(Pose(self.obj.position, self.obj.rotation))

    @property
    def present(self) -> bool:
        """Whether the body is in the scene: active and not removed."""
        return self.active and not self.removed

    @property
    def box(self) -> Box:
        """Current oriented box. It is fixed in the object's frame."""
        return self.box_at(self.pose)

    def box_at(self, pose: Pose) -> Box:
        """Return the oriented box that the body has at `pose`."""
        recorded = self.obj.box
        if pose.position is self.obj.position and pose.rotation is self.obj.rotation:
            return recorded
        turn = pose.rotation @ self.obj.rotation.T
        return Box(pose.position + turn @ (recorded.centre - self.obj.position), recorded.half, turn @ recorded.rotation)

    def pose_for(self, box: Box) -> Pose:
        """Return the pose at which the oriented box is `box`: the inverse of `box_at`."""
        turn = box.rotation @ self.obj.box.rotation.T
        return Pose(box.centre - turn @ (self.obj.box.centre - self.obj.position), turn @ self.obj.rotation)
