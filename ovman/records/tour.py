"""The tour of a visit: where the agent stands and which way it looks."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ovman.records.geometry import Point, Spawn
from ovman.records.record import DEGREE_DECIMALS, Record
from ovman.records.sensors import Light, Sensors


class Tour(Record):
    """The tour of one visit: its waypoints in metres, in order, and the views at each, equally spaced in yaw.

    headings: views at a waypoint. first_yaw_deg: yaw of the first of them, degrees. light: None for the scene's own; sensors:
    None for exact ones.
    """

    waypoints: tuple[Point, ...] = Field(min_length=1)
    headings: int = Field(ge=1)
    first_yaw_deg: Annotated[float, Field(ge=0, lt=360)] = 0.0
    light: Light | None = None
    sensors: Sensors | None = None

    @property
    def poses(self) -> tuple[Spawn, ...]:
        """Where the agent stands and looks at each view, in order; degrees as records round them."""
        yaws = [self.first_yaw_deg + 360.0 * k / self.headings for k in range(self.headings)]
        return tuple(Spawn(x=x, z=z, yaw_deg=round(yaw % 360.0, DEGREE_DECIMALS)) for x, z in self.waypoints for yaw in yaws)
