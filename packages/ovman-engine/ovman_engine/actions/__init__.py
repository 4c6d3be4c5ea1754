"""What a client can ask for: one function an action. Importing the package fills the table."""

from ovman_engine.actions import (
    cameras,
    gaze,
    house,
    materials,
    movement,
    navigation,
    objects,
    physics,
    raycast,
    reach,
    scene,
    spawning,
    teleport,
)
from ovman_engine.actions.registry import TABLE

__all__ = [
    "TABLE",
    "cameras",
    "gaze",
    "house",
    "materials",
    "movement",
    "navigation",
    "objects",
    "physics",
    "raycast",
    "reach",
    "scene",
    "spawning",
    "teleport",
]
