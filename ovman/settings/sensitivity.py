"""What is varied to see how much a result depends on it: the thresholds of admissibility, and the association gate."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Annotated, Self

from pydantic import Field, field_validator, model_validator

from ovman.section import Count, Listed, Metres, Section, Some
from ovman.settings.benchmark import Measurement

Lengths = Annotated[tuple[Metres, ...], Listed, Field(min_length=1)]
Pixels = Annotated[tuple[Some, ...], Listed, Field(min_length=1)]

THRESHOLDS: Mapping[str, str] = {
    "drift_tolerance_m": "admissibility.drift_tolerance_m",
    "tau_m": "admissibility.tau_m",
    "delta_min_m": "candidates.delta_min_m",
    "min_mask_px": "admissibility.min_mask_px",
    "motion_m": "admissibility.motion_m",
    "validity_radius_m": "admissibility.validity_radius_m",
    "spawn_clearance_m": "candidates.spawn_clearance_m",
    "visible_px": "success.visible_px",
}
"""The constant of config.yaml that each list of section `sensitivity` has values of: all that a verdict reads."""


class Sensitivity(Section):
    """Under which settings of its thresholds admissibility is re-derived: every combination of one value of each list."""

    combinations: Count = Field(description="how many settings that makes; refused where the lists make another number")
    drift_tolerance_m: Lengths = Field(description="metres")
    tau_m: Lengths = Field(description="metres, tau of Eq. 1 and of the bystanders; the agent's stays")
    delta_min_m: Lengths = Field(description="metres, Delta_min of the predicates and of the applied displacement")
    min_mask_px: Pixels = Field(description="pixels from which an instance is recorded")
    motion_m: Lengths = Field(description="metres between recorded positions from which on they are motion")
    validity_radius_m: Lengths = Field(description="metres from the answer to a navigable cell")
    spawn_clearance_m: Lengths = Field(description="metres from the spawn to the change")
    visible_px: Pixels = Field(description="pixels of the target from the nearest navigable cell")

    @field_validator(*THRESHOLDS)
    @classmethod
    def _distinct(cls, values: tuple[float, ...]) -> tuple[float, ...]:
        if len(set(values)) < len(values):
            raise ValueError("a value is there twice")
        return values

    @model_validator(mode="after")
    def _counted(self) -> Self:
        if (made := math.prod(len(getattr(self, name)) for name in THRESHOLDS)) != self.combinations:
            raise ValueError(f"combinations is {self.combinations}, but the lists make {made}; change one of them")
        return self

    def settings(self) -> Iterator[dict[str, float]]:
        """Yield every setting: the values of the thresholds by the names of their lists; the last list varies fastest."""
        for values in product(*(getattr(self, name) for name in THRESHOLDS)):
            yield dict(zip(THRESHOLDS, values, strict=True))


class GateSweep(Section):
    """Under which association gates the static arm of `comparisons.memory` answers again (Fig. diag)."""

    gates_m: Lengths = Field(description="metres, values of gamma")

    @field_validator("gates_m")
    @classmethod
    def _rising(cls, gates_m: tuple[float, ...]) -> tuple[float, ...]:
        if list(gates_m) != sorted(set(gates_m)):
            raise ValueError("the gates do not rise")
        return gates_m


def contradictions(sensitivity: Sensitivity, measurement: Measurement) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield values that trials were not measured for, or that make Eq. 1 contradict itself: the place, and what is to be said."""
    for name, bound in (("min_mask_px", measurement.min_mask_px), ("visible_px", measurement.visible_px)):
        if (least := min(getattr(sensitivity, name))) < bound:
            yield ("sensitivity", name), f"has {least}, but measurement.{name} is {bound}, below which nothing is measured"
    if (most := max(sensitivity.validity_radius_m)) > measurement.answer_to_navigable_m:
        limit = measurement.answer_to_navigable_m
        yield ("sensitivity", "validity_radius_m"), f"has {most}, but measurement.answer_to_navigable_m is {limit}"
    if (tau_m := max(sensitivity.tau_m)) >= (delta_m := min(sensitivity.delta_min_m)):
        says = f"has {tau_m}, but delta_min_m has {delta_m}: an instance would be stable and moved at once"
        yield ("sensitivity", "tau_m"), says
