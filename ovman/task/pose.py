"""Points and poses in records."""

from __future__ import annotations

from dataclasses import dataclass

from ovman.task.record import Node
from ovman.task.world_state import Point


@dataclass(frozen=True, slots=True)
class Spawn:
    """A pose of the agent: floor plane in metres, yaw in degrees (0 looks along +z, 90 along +x)."""

    x: float
    z: float
    yaw_deg: float

    @staticmethod
    def read(node: Node) -> Spawn:
        return Spawn(*read_point(node), node["yaw_deg"].number())

    def to_json(self) -> dict[str, float]:
        return {"x": float(self.x), "z": float(self.z), "yaw_deg": float(self.yaw_deg)}


@dataclass(frozen=True, slots=True)
class Position:
    """A position in the room, metres, world frame, y up."""

    x: float
    y: float
    z: float

    @staticmethod
    def read(node: Node) -> Position:
        return Position(node["x"].number(), node["y"].number(), node["z"].number())

    def to_json(self) -> dict[str, float]:
        return {"x": float(self.x), "y": float(self.y), "z": float(self.z)}


def read_point(node: Node) -> Point:
    return node["x"].number(), node["z"].number()


def read_points(node: Node) -> tuple[Point, ...]:
    return tuple(read_point(point) for point in node.elements())


def point_to_json(point: Point) -> dict[str, float]:
    return {"x": float(point[0]), "z": float(point[1])}
