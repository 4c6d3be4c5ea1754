"""The constant of REACT: section `react` of the settings. A file of settings may override it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ovman.section import Section


class React(Section):
    """REACT's clusters of instances."""

    # The released 1.0 to 2.5, one per scene, are distances of a network that was trained per scene. This one separates looks
    # alike from others best on held-out floor plans, which neither the benchmark nor a training has (training/thresholds.py).
    appearance: Annotated[float, Field(ge=0, le=2)] = Field(
        0.25, description="distance of two unit features up to which clusters of a category are one"
    )
