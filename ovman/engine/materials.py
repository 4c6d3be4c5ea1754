"""Colour and texture of an instance's slots, drawn from a hash of its asset and its scene, never from its type.

Colour must not give the category away, so nothing here reads the type except to group what is built in (cabinet fronts match each other).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ovman.engine.floorplan import FloorPlan, SimObject
from ovman.engine.shapes.style import Style

TEXTURES = (
    "plain wood fabric weave tiles marble metal_brushed print picture leaves pages cardboard checker stripes screen".split()
)
SLOTS = "main second accent trim metal dark pale cloth cloth_second glass screen glow sky leaf leaf_second soil picture pages mirror rubber".split()


@dataclass(frozen=True, eq=False)
class Material:
    """How a surface looks."""

    colour: np.ndarray
    """(3,) linear RGB, 0 to 1"""
    texture: str = "plain"
    scale_m: float = 0.2
    """Period of the texture, metres"""
    seed: int = 0
    gloss: float = 0.1
    """0 dull to 1 mirror-like"""
    emission: float = 0.0
    """0 to 1; what glows by itself"""


def linear(hue: float, saturation: float, lightness: float) -> np.ndarray:
    """Linear RGB (3,) of an HSL colour given in [0, 1] with sRGB primaries."""
    k = (np.array([0.0, 8.0, 4.0]) + hue * 12.0) % 12.0
    display = lightness - saturation * min(lightness, 1 - lightness) * np.clip(np.minimum(k - 3, 9 - k), -1, 1)
    return np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4)


def palette(obj: SimObject, plan: FloorPlan) -> Mapping[str, Material]:
    """Material of every slot of `obj`."""
    style = Style(f"{plan.name}|{obj.asset_id or obj.name}")
    return {
        slot: Material(
            linear(
                style.fraction(slot + " hue"),
                style.uniform(slot + " saturation", 0.1, 0.5),
                style.uniform(slot + " lightness", 0.25, 0.75),
            ),
            seed=style.integer(slot) % 2**31,
        )
        for slot in SLOTS
    }
