"""Section `sensors`: how depth and poses err, by level. A split without a level has exact sensors."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ovman.section import Section

Spread = Annotated[float, Field(ge=0)]


class Errors(Section):
    """Standard deviations of normal errors.

    A depth z has that of `depth_m + depth_per_m2 * (z - depth_nearest_m)^2`, each pixel its own. A visit begins at a pose that is
    wrong by `pose_m` along each axis of the floor and by `pose_deg`. What is gone and turned since then is measured with errors
    that grow as the root of what was done.
    """

    depth_m: Spread = Field(description="metres, of the depth of what is depth_nearest_m away")
    depth_per_m2: Spread = Field(description="metres per square metre, how it grows with the distance beyond that")
    depth_nearest_m: Spread = Field(description="metres, nearest distance that the sensor is made for")
    pose_m: Spread = Field(description="metres, of the position where a visit begins, along each axis")
    pose_deg: Spread = Field(description="degrees, of the yaw there")
    drift_m: Spread = Field(description="metres per root of a metre gone, along each axis")
    drift_deg: Spread = Field(description="degrees per root of a metre gone, and per root of a full turn")


class Levels(Section):
    """The levels that a split may name."""

    good: Errors = Field(description="of a robot that is well calibrated and localised")
    poor: Errors = Field(description="of one that is not")


Level = Literal["good", "poor"]
