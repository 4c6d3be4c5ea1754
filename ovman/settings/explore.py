"""The values between which the page of `ovman explore` moves a threshold."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import Field

from ovman.section import Section
from ovman.settings.sensitivity import Lengths, Pixels

MOVED: Mapping[str, str] = {
    "drift_tolerance_m": "admissibility.drift_tolerance_m",
    "tau_m": "admissibility.tau_m",
    "delta_min_m": "candidates.delta_min_m",
    "min_mask_px": "admissibility.min_mask_px",
    "validity_radius_m": "admissibility.validity_radius_m",
    "radius_m": "success.radius_m",
}
"""The constant of config.yaml that each list of section `explore` has values of."""


class Explore(Section):
    """Positions of the sliders of `ovman explore`. The value in force is always one of them."""

    drift_tolerance_m: Lengths = Field(description="metres")
    tau_m: Lengths = Field(description="metres, tau of Eq. 1 and of the bystanders; the agents' stays")
    delta_min_m: Lengths = Field(description="metres, Delta_min")
    min_mask_px: Pixels = Field(description="pixels from which an instance is recorded; none below measurement.min_mask_px")
    validity_radius_m: Lengths = Field(description="metres; none beyond measurement.answer_to_navigable_m")
    radius_m: Lengths = Field(description="metres, R of the success test")
