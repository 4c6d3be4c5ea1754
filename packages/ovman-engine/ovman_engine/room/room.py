"""What bounds a scene: the walls that the agent and the objects meet, and the structures that are drawn.

World frame as in `floorplan`; plan rectangles are (x_0, z_0, x_1, z_1), metres.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ovman_engine.paint import finishes
from ovman_engine.paint.finishes import Material
from ovman_engine.plan.floorplan import Box, FloorPlan
from ovman_engine.shapes.part import Part, column
from ovman_engine.shapes.style import Style

Rectangle = tuple[float, float, float, float]
Structure = tuple[str, tuple[Part, ...], Mapping[str, Material]]
"""Name, parts in the world frame and palette by slot of something that is drawn and is no object."""


@dataclass(frozen=True)
class Wall:
    """A solid with a vertical face towards the room."""

    name: str
    box: Box


@dataclass(frozen=True)
class Block:
    """A wall inside the outline, behind an item that hangs deeper in the room than others.

    It is a stretch of everything beyond a plane.
    """

    axis: int
    """0: the plane is x = `plane`; 1: it is z = `plane`"""
    outwards: int
    """-1 if the solid lies towards lower coordinates, else 1"""
    plane: float
    low: float
    high: float
    thick: float = np.inf
    """Infinite, except for a partition, which has room on both sides"""

    def rectangle(self, beyond: Rectangle) -> Rectangle:
        """Plan rectangle of the block, cut at the sides of `beyond`."""
        first, last = np.zeros(2), np.zeros(2)
        first[1 - self.axis], last[1 - self.axis] = self.low, self.high
        if self.outwards < 0:
            first[self.axis], last[self.axis] = max(beyond[self.axis], self.plane - self.thick), self.plane
        else:
            first[self.axis], last[self.axis] = self.plane, min(beyond[2 + self.axis], self.plane + self.thick)
        return float(first[0]), float(first[1]), float(last[0]), float(last[1])


@dataclass(frozen=True)
class Room(ABC):
    """What bounds a floor plan."""

    plan: FloorPlan
    rectangle: Rectangle
    """Bounds of the agent's body"""
    outline: Rectangle
    """Bounds of all objects, and the visible walls"""
    blocks: tuple[Block, ...]
    """Solid parts of the outline"""
    walls: tuple[Wall, ...]
    """Obstacles of the agent"""
    solids: tuple[Wall, ...]
    """Obstacles of bodies: the outline, the blocks, the stoves, of which floor plans record only burners and knobs, and a shell
    around all objects, for those that stand in a wall from the beginning"""
    ceiling_y: float

    @property
    def floor_y(self) -> float:
        """Height of the floor, metres."""
        return self.plan.floor_y

    @abstractmethod
    def lamps(self) -> tuple[np.ndarray, ...]:
        """Return where lamps hang from the ceiling, (3,) metres each."""

    @abstractmethod
    def parts(self) -> tuple[Structure, ...]:
        """List the structures that are drawn, with unique names."""


LAMP_M, RIM_M, GLASS_M = (0.16, 0.24), 0.025, 0.05
"""Range of the radius of a ceiling lamp; heights of its rim and of its glass."""


def lamp(room: Room, at: np.ndarray) -> tuple[tuple[Part, ...], Mapping[str, Material]]:
    """Return a flat lamp that hangs from the ceiling: parts and palette. All lamps of a scene are alike."""
    style = Style(f"{room.plan.name if room.plan.house is None else room.plan.house.name}|ceiling lamp")
    radius, (x, y, z) = style.uniform("radius", *LAMP_M), at
    parts = (
        column(x, z, y - RIM_M, y, radius, "metal", segments=24),
        column(x, z, y - GLASS_M, y - RIM_M, 0.88 * radius, "main", segments=24),
    )
    glass = Material(finishes.linear(0.12, 0.3, 0.9), emission=0.7, gloss=0.0)
    return parts, {"main": glass, "metal": finishes.metal(Style(f"{style.key}|rim"))}


def structure_name(kind: str, centre: np.ndarray) -> str:
    """Name of a structure as AI2-THOR writes it: kind|x|y|z."""
    return kind + "".join(f"|{value:+06.2f}" for value in centre)
