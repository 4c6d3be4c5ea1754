"""The actions of a client, one function each. Importing the package registers all of them."""

from ovman_engine.actions import (
    camera_pose,
    cameras,
    house,
    interactable_poses,
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
    "interactable_poses",
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
