"""REACT, reimplemented: clusters of instances that look alike, matched between two visits by the distance that they travelled.

Written from the behaviour of the released code (Nguyen, Verdoja and Kyrki, "REACT:
Real-time Efficient Attribute Clustering and Transfer for Updatable 3D Scene Graph", 2025; aalto-intelligent-robotics/REACT, MIT).
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ovman.section import Section


class React(Section):
    """REACT's clusters of instances."""

    # The released 1.0 to 2.5, one per scene, are distances of a network that was trained per scene. This one separates looks
    # alike from others best on held-out floor plans, which neither the benchmark nor a training has (training/thresholds.py).
    appearance: Annotated[float, Field(ge=0, le=2)] = Field(
        0.525, description="distance of two unit features up to which clusters of a category are one"
    )
