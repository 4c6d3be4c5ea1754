"""Sensors that err, and the light that they see: what a tour has beside its poses."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ovman.records.record import Record
from ovman.settings.sensors import Errors


class Light(Record):
    """The light of a visit, by AI2-THOR's RandomizeLighting with equal ends of every range, and what it falls on.

    brightness: factor of every light; hue, saturation: of their tint, in [0, 1]; materials: seed of RandomizeMaterials, not
    written where the scene has its own.
    """

    brightness: float = Field(gt=0)
    hue: float = Field(ge=0, le=1)
    saturation: float = Field(ge=0, le=1)
    materials: Annotated[int, Field(ge=0)] | None = Field(None, exclude_if=lambda seed: seed is None)


class Sensors(Record):
    """The sensors of a visit. errors: a level of section `sensors`; seed: what they draw from."""

    errors: Errors
    seed: int = Field(ge=0)
