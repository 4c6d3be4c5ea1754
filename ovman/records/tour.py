"""The tour of a visit: poses of the agent, the light, and sensors that err."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from ovman.records.geometry import Point, Spawn
from ovman.records.record import DEGREE_DECIMALS, Record, optional
from ovman.settings.benchmark import Errors


class Light(Record):
    """The light of a visit, by AI2-THOR's RandomizeLighting with equal ends of every range, and what it falls on.

    brightness: factor of every light; hue, saturation: of their tint, in [0, 1]; materials: seed of RandomizeMaterials, not
    written where the scene has its own.
    """

    brightness: float = Field(gt=0)
    hue: float = Field(ge=0, le=1)
    saturation: float = Field(ge=0, le=1)
    materials: Annotated[int, Field(ge=0)] | None = optional()


class Sensors(Record):
    """The sensors of a visit. errors: a level of section `sensors`; seed: what they draw from."""

    errors: Errors
    seed: int = Field(ge=0)


class Tour(Record):
    """The tour of one visit: its waypoints in metres, in order, and the views at each, equally spaced in yaw.

    headings: views at a waypoint. first_yaw_deg: yaw of the first of them, degrees. turned_deg: how far each view is turned from
    the equal spacing, None for not at all. light: None for the scene's own; sensors:
    None for exact ones.
    """

    waypoints: tuple[Point, ...] = Field(min_length=1)
    headings: int = Field(ge=1)
    first_yaw_deg: Annotated[float, Field(ge=0, lt=360)] = 0.0
    light: Light | None = None
    sensors: Sensors | None = None
    turned_deg: tuple[float, ...] | None = optional()

    @model_validator(mode="after")
    def _turned(self) -> Self:
        views = len(self.waypoints) * self.headings
        if self.turned_deg is not None and len(self.turned_deg) != views:
            raise ValueError(f"turned_deg has {len(self.turned_deg)} angles; the tour has {views} views")
        return self

    @property
    def poses(self) -> tuple[Spawn, ...]:
        """Where the agent stands and looks at each view, in order; degrees as records round them."""
        yaws = [self.first_yaw_deg + 360.0 * k / self.headings for k in range(self.headings)]
        views = [(x, z, yaw) for x, z in self.waypoints for yaw in yaws]
        turned = self.turned_deg or (0.0,) * len(views)
        return tuple(
            Spawn(x=x, z=z, yaw_deg=round((yaw + more) % 360.0, DEGREE_DECIMALS))
            for (x, z, yaw), more in zip(views, turned, strict=True)
        )
