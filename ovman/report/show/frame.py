"""From the floor plane to a drawing seen from above: x to the right, z up, as yaw 0 looks along +z and 90 along +x."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class PlanFrame:
    """A drawing of `width` x `height` units whose upper left corner is (x_min, z_max), `scale` units a metre."""

    x_min: float
    z_max: float
    scale: float
    width: float
    height: float

    @staticmethod
    def around(points: Iterable[Point], width: float, highest: float, margin_m: float) -> PlanFrame:
        """The largest frame `width` wide and at most `highest` high that shows the points (x, z), metres, and `margin_m` about
        them, in the middle. ValueError without points.
        """
        points = list(points)
        if not points:
            raise ValueError("a frame needs a point to go around")
        (left, right), (low, high) = ((min(axis) - margin_m, max(axis) + margin_m) for axis in zip(*points, strict=True))
        scale = min(width / (right - left), highest / (high - low))
        spare = width / scale - (right - left)
        return PlanFrame(left - spare / 2, high, scale, width, (high - low) * scale)

    def at(self, x: float, z: float) -> Point:
        """Where a floor-plane point in metres is drawn: units from the left and from the top."""
        return (x - self.x_min) * self.scale, (self.z_max - z) * self.scale

    def world(self, u: float, v: float) -> Point:
        """The floor-plane point (x, z) in metres that is drawn at (u, v); inverse of `at`."""
        return self.x_min + u / self.scale, self.z_max - v / self.scale

    def shows(self, x: float, z: float) -> bool:
        """Whether a floor-plane point lies within the drawing."""
        u, v = self.at(x, z)
        return 0 <= u <= self.width and 0 <= v <= self.height
