"""What a client can ask for: one function an action. Importing the package fills the table."""

from ovman.engine.actions import cameras, materials, movement, objects, physics, scene
from ovman.engine.actions.registry import TABLE

__all__ = ["TABLE", "cameras", "materials", "movement", "objects", "physics", "scene"]
