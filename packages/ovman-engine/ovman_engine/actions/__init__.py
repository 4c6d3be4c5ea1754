"""What a client can ask for: one function an action. Importing the package fills the table."""

from ovman_engine.actions import (
    camera_pose,
    cameras,
    house,
    materials,
    movement,
    navigation,
    objects,
    physics,
    raycast,
    reachable,
    scene,
    spawning,
    teleport,
)
from ovman_engine.actions.registry import TABLE

__all__ = [
    "TABLE",
    "cameras",
    "camera_pose",
    "house",
    "materials",
    "movement",
    "navigation",
    "objects",
    "physics",
    "raycast",
    "reachable",
    "scene",
    "spawning",
    "teleport",
]
