"""What a world is made of: objects where they are now, and the agent. World frame as in `floorplan`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ovman_engine.bodies.embodiment import DEFAULT, Embodiment
from ovman_engine.plan.floorplan import Box, SimObject

STAYS_M = 1e-3
"""A body is where it was if its pivot, and the tips of its unit axes, are no farther from where they were."""


@dataclass(frozen=True)
class Pose:
    """Where an object's pivot is, (3,) metres, and its rotation, (3, 3) from object to world axes."""

    position: np.ndarray
    rotation: np.ndarray


@dataclass
class Agent:
    """The agent: its position (3,) in metres, 0.9 m above its feet; horizon positive is down."""

    position: np.ndarray
    yaw_deg: float = 0.0
    horizon_deg: float = 0.0
    standing: bool = True
    """Always so for an embodiment that does not crouch."""
    embodiment: Embodiment = DEFAULT

    @property
    def camera(self) -> np.ndarray:
        """Position of the camera, (3,) metres."""
        return self.position + [0.0, self.embodiment.camera_m(self.standing), 0.0]

    @property
    def foot(self) -> float:
        """Height of the lower end of its capsule, metres."""
        return float(self.position[1]) + self.embodiment.foot_m


@dataclass
class Body:
    """An object as it is now."""

    obj: SimObject
    """The object as the floor plan has it."""
    object_id: str
    name: str
    pose: Pose
    active: bool = True
    removed: bool = False
    dynamic: bool = False
    kinematic: bool = False
    """Put somewhere for good: gravity does not move it."""
    carrier: str | None = None
    """objectId of the body that this one is a part of (a drawer of a dresser): it goes where that one goes."""
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """(6,) linear, then angular, m/s and rad/s, world frame."""

    @staticmethod
    def of(obj: SimObject) -> Body:
        """`obj`, untouched."""
        return Body(obj, obj.object_id, obj.name, Pose(obj.position, obj.rotation), dynamic=obj.dynamic)

    @property
    def untouched(self) -> bool:
        """Whether it is where the floor plan has it and was never put anywhere."""
        return self.pose.position is self.obj.position and self.pose.rotation is self.obj.rotation

    @property
    def stays(self) -> bool:
        """Whether it is where the floor plan has it, touched or not."""
        moved = np.abs(self.pose.position - self.obj.position).max()
        return bool(moved < STAYS_M and np.abs(self.pose.rotation - self.obj.rotation).max() < STAYS_M)

    @property
    def present(self) -> bool:
        return self.active and not self.removed

    @property
    def box(self) -> Box:
        """Current oriented box: it keeps its place in the object's frame."""
        return self.box_at(self.pose)

    def box_at(self, pose: Pose) -> Box:
        """Oriented box that it would have at `pose`."""
        recorded = self.obj.box
        if pose.position is self.obj.position and pose.rotation is self.obj.rotation:
            return recorded
        turn = pose.rotation @ self.obj.rotation.T
        return Box(pose.position + turn @ (recorded.centre - self.obj.position), recorded.half, turn @ recorded.rotation)

    def pose_for(self, box: Box) -> Pose:
        """Pose at which its oriented box is `box`: the inverse of `box_at`."""
        turn = box.rotation @ self.obj.box.rotation.T
        return Pose(box.centre - turn @ (self.obj.box.centre - self.obj.position), turn @ self.obj.rotation)
