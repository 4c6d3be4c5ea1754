"""Finishes: wood, paint, cloth, metal, ceramic and others, each drawn from its tones.

A finish is a function of a `Style`, a reproducible source of choices. Tones are hue, saturation and lightness (HSL over sRGB).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ovman_engine.paint.tones import ALLOYS, CLOTHS, GILTS, GLAZES, GREYS, LEATHERS, PAINTS, PLASTICS, WHITES, WOODS, Tone
from ovman_engine.shapes.style import Style


@dataclass(frozen=True, eq=False)
class Material:
    """The appearance of a surface."""

    colour: np.ndarray
    """(3,) linear RGB, 0 to 1"""
    texture: str = "plain"
    scale_m: float = 0.2
    """Period of the texture, metres"""
    seed: int = 0
    gloss: float = 0.1
    """0 dull to 1 mirror-like"""
    emission: float = 0.0
    """0 to 1; light of its own"""
    clear: bool = False
    """Glass: the surface behind it is seen through it. Needs a gloss of at least `optics.MIRROR`."""


Finish = Callable[[Style], Material]


def linear(hue: float, saturation: float, lightness: float) -> np.ndarray:
    """Linear RGB (3,) of an HSL colour in [0, 1] with sRGB primaries."""
    k = (np.array([0.0, 8.0, 4.0]) + hue * 12.0) % 12.0
    display = lightness - saturation * min(lightness, 1 - lightness) * np.clip(np.minimum(k - 3, 9 - k), -1, 1)
    return np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4)


def toned(
    s: Style,
    tones: tuple[Tone, ...],
    texture: str = "plain",
    scale: tuple[float, float] = (0.2, 0.2),
    gloss: tuple[float, float] = (0.05, 0.3),
    slack: float = 0.06,
    **fields: Any,
) -> Material:
    """Return a material of one of `tones`, with random deviations of hue, saturation and lightness (up to `slack`)."""
    hue, saturation, lightness = s.choice("tone", tones)
    colour = linear(
        (hue + s.uniform("hue", -0.3, 0.3) * slack) % 1.0,
        float(np.clip(saturation * (1 + s.uniform("saturation", -4, 4) * slack), 0.0, 0.9)),
        float(np.clip(lightness + s.uniform("lightness", -1, 1) * slack, 0.04, 0.93)),
    )
    return Material(colour, texture, s.uniform("scale", *scale), gloss=s.uniform("gloss", *gloss), **fields)


def of(*tones: Tone, **looks: Any) -> Finish:
    """Return the finish with `tones`; other arguments as in `toned`."""
    return lambda s: toned(s, tones, **looks)


def either(*finishes: Finish) -> Finish:
    """One of several finishes; a finish that is listed twice is twice as likely."""
    return lambda s: s.choice("family", finishes)(s)


def patterned(plain: Finish, often: float, patterns: tuple[tuple[str, float, float], ...]) -> Finish:
    """`plain`, or with probability `often` a pattern: (texture, least and largest period in metres)."""

    def finish(s: Style) -> Material:
        made = plain(s)
        if not s.chance("patterned", often):
            return made
        texture, low, high = s.choice("pattern", patterns)
        return replace(made, texture=texture, scale_m=s.uniform("period", low, high))

    return finish


wood = of(*WOODS, texture="wood", scale=(0.14, 0.4), gloss=(0.05, 0.32), slack=0.05)
white_paint = of(*WHITES, gloss=(0.05, 0.3), slack=0.03)
grey_paint = of(*GREYS, gloss=(0.05, 0.3))
paint = of(*PAINTS, gloss=(0.05, 0.3))
painted = either(white_paint, white_paint, white_paint, grey_paint, grey_paint, paint, paint)
furniture = either(wood, wood, wood, wood, wood, white_paint, white_paint, grey_paint, paint)
cabinetry = either(wood, wood, wood, white_paint, white_paint, white_paint, grey_paint, paint)

steel = of(*ALLOYS, texture="metal_brushed", scale=(0.1, 0.1), gloss=(0.3, 0.5), slack=0.05)
gilt = of(*GILTS, texture="metal_brushed", scale=(0.1, 0.1), gloss=(0.45, 0.75), slack=0.05)
black_metal = of((0.6, 0.03, 0.11), (0.07, 0.15, 0.14), gloss=(0.2, 0.45), slack=0.03)
metal = either(steel, steel, steel, gilt, black_metal)
chrome = of(*ALLOYS, gloss=(0.6, 0.8), slack=0.05)
cast_iron = of((0.6, 0.03, 0.1), (0.07, 0.06, 0.14), gloss=(0.1, 0.35), slack=0.03)
enamel = either(
    of(*WHITES, gloss=(0.4, 0.6), slack=0.03),
    of((0.6, 0.04, 0.13), gloss=(0.4, 0.6), slack=0.04),
    steel,
    steel,
    of((0.0, 0.55, 0.4), (0.12, 0.3, 0.78), (0.46, 0.2, 0.66), (0.58, 0.3, 0.5), gloss=(0.4, 0.6)),
)

FIGURES = (("stripes", 0.03, 0.09), ("checker", 0.03, 0.07), ("print", 0.05, 0.1))
_cloth = of(*CLOTHS, texture="fabric", scale=(0.01, 0.03), gloss=(0.0, 0.06))
cloth = patterned(patterned(_cloth, 0.3, (("weave", 0.008, 0.016),)), 0.16, FIGURES)
leather = of(*LEATHERS, gloss=(0.25, 0.45), slack=0.05)
upholstery = either(cloth, cloth, cloth, cloth, cloth, leather)
towelling = patterned(
    of(*WHITES, *WHITES, *CLOTHS, texture="fabric", scale=(0.01, 0.02), gloss=(0.0, 0.03)), 0.15, (("stripes", 0.03, 0.08),)
)
linen = of(*WHITES, *WHITES, (0.58, 0.2, 0.8), (0.01, 0.22, 0.82), texture="fabric", scale=(0.02, 0.04), gloss=(0.0, 0.05))
bedding = patterned(of(*WHITES, *CLOTHS, texture="fabric", scale=(0.02, 0.04), gloss=(0.0, 0.05)), 0.3, FIGURES)
drapery = patterned(of(*WHITES, *CLOTHS, texture="fabric", scale=(0.01, 0.03), gloss=(0.0, 0.05)), 0.22, FIGURES)

ceramic = of(*WHITES, *WHITES, (0.6, 0.08, 0.82), gloss=(0.4, 0.6), slack=0.03)
glaze = of(*GLAZES, gloss=(0.25, 0.6))
patterned_glaze = patterned(glaze, 0.16, (("stripes", 0.015, 0.05), ("print", 0.03, 0.06)))
terracotta = of((0.045, 0.48, 0.5), (0.06, 0.4, 0.58), (0.04, 0.4, 0.4), gloss=(0.0, 0.1))
tinted_glass = of((0.33, 0.3, 0.3), (0.5, 0.3, 0.55), (0.09, 0.5, 0.28), (0.6, 0.4, 0.4), (0.45, 0.1, 0.75), gloss=(0.6, 0.8))
bottle_glass = of((0.33, 0.35, 0.2), (0.3, 0.35, 0.28), (0.08, 0.5, 0.2), (0.45, 0.15, 0.6), (0.6, 0.4, 0.3), gloss=(0.6, 0.8))
plastic = of(*PLASTICS, gloss=(0.15, 0.5))
casing = either(
    of((0.6, 0.04, 0.1), (0.6, 0.04, 0.18), gloss=(0.2, 0.5), slack=0.04),
    of((0.6, 0.04, 0.1), (0.6, 0.04, 0.18), gloss=(0.2, 0.5), slack=0.04),
    of((0.6, 0.04, 0.6), (0.6, 0.05, 0.72), texture="metal_brushed", gloss=(0.35, 0.6)),
    white_paint,
)
"""Housings of electronic devices."""

stone = either(
    of(
        (0.09, 0.1, 0.8),
        (0.6, 0.04, 0.84),
        (0.6, 0.04, 0.55),
        (0.09, 0.16, 0.66),
        texture="marble",
        scale=(0.25, 0.7),
        gloss=(0.3, 0.55),
    ),
    of(
        (0.6, 0.05, 0.22),
        (0.6, 0.06, 0.42),
        (0.08, 0.18, 0.34),
        (0.4, 0.1, 0.24),
        texture="speckle",
        scale=(0.006, 0.012),
        gloss=(0.3, 0.5),
    ),
)
worktop = either(stone, stone, stone, wood, of(*WHITES, *GREYS, texture="speckle", scale=(0.005, 0.009), gloss=(0.2, 0.45)))
sculpture = either(
    of(*WHITES, (0.1, 0.14, 0.7), gloss=(0.05, 0.3)),
    of(*GILTS, gloss=(0.4, 0.65)),
    of((0.6, 0.03, 0.14), (0.6, 0.04, 0.4), gloss=(0.1, 0.5)),
    wood,
    glaze,
    of((0.09, 0.1, 0.75), (0.4, 0.1, 0.4), (0.04, 0.2, 0.5), texture="marble", scale=(0.2, 0.4), gloss=(0.2, 0.5)),
)
wicker = of((0.09, 0.38, 0.54), (0.085, 0.34, 0.4), (0.1, 0.26, 0.7), (0.07, 0.3, 0.26), texture="weave", scale=(0.014, 0.022))
cardboard = of((0.085, 0.36, 0.52), (0.085, 0.34, 0.46), (0.08, 0.36, 0.58), texture="cardboard", gloss=(0.0, 0.05), slack=0.05)
card = of(*WHITES, *PLASTICS, (0.6, 0.4, 0.4), gloss=(0.1, 0.4))
binding = of(*CLOTHS, *LEATHERS, *PLASTICS, gloss=(0.05, 0.35))
"""Covers of books."""
paper = of((0.12, 0.08, 0.9), (0.1, 0.14, 0.86), gloss=(0.0, 0.04), slack=0.02)
pages = of((0.12, 0.2, 0.84), (0.11, 0.26, 0.78), texture="pages", scale=(0.01, 0.01), gloss=(0.0, 0.0), slack=0.04)
newsprint = of((0.12, 0.08, 0.78), (0.11, 0.14, 0.74), texture="text", scale=(0.009, 0.012), gloss=(0.0, 0.0), slack=0.03)
wax = of((0.12, 0.3, 0.84), (0.1, 0.1, 0.9), *PAINTS, (0.0, 0.6, 0.42), (0.76, 0.2, 0.6), (0.09, 0.4, 0.6), gloss=(0.1, 0.3))
rubber = of((0.02, 0.5, 0.3), (0.6, 0.03, 0.12), (0.6, 0.04, 0.3), (0.03, 0.4, 0.22), gloss=(0.05, 0.2))
sponge = of(
    (0.14, 0.7, 0.6),
    (0.36, 0.45, 0.45),
    (0.55, 0.45, 0.58),
    (0.95, 0.5, 0.68),
    (0.08, 0.6, 0.58),
    texture="speckle",
    scale=(0.008, 0.012),
    gloss=(0.0, 0.0),
)
soap = of((0.12, 0.3, 0.86), (0.95, 0.3, 0.8), (0.3, 0.25, 0.7), (0.55, 0.3, 0.76), (0.1, 0.4, 0.66), gloss=(0.2, 0.4))
fur = of(
    (0.08, 0.42, 0.42),
    (0.08, 0.36, 0.56),
    (0.1, 0.2, 0.8),
    (0.06, 0.3, 0.26),
    (0.95, 0.25, 0.72),
    (0.6, 0.04, 0.6),
    texture="fabric",
    scale=(0.01, 0.02),
    gloss=(0.0, 0.0),
)
foliage = of(
    (0.27, 0.42, 0.30),
    (0.31, 0.40, 0.25),
    (0.24, 0.42, 0.38),
    (0.35, 0.32, 0.32),
    (0.21, 0.42, 0.42),
    (0.42, 0.22, 0.38),
    texture="leaves",
    gloss=(0.05, 0.25),
)
soil = of((0.07, 0.32, 0.14), (0.06, 0.28, 0.2), texture="fabric", scale=(0.02, 0.02), gloss=(0.0, 0.0), slack=0.03)
dark = of((0.6, 0.04, 0.1), (0.6, 0.05, 0.16), (0.08, 0.08, 0.12), gloss=(0.1, 0.5), slack=0.03)
pale = of((0.12, 0.16, 0.87), (0.1, 0.1, 0.82), gloss=(0.0, 0.2), slack=0.03)
accent = either(plastic, glaze, painted, wood)


def shade(s: Style) -> Material:
    """Return a lampshade: cloth or paper, lit or not."""
    made = toned(
        s, (*WHITES, *WHITES, (0.11, 0.36, 0.76), *CLOTHS), s.choice("stuff", ("plain", "fabric")), (0.02, 0.03), (0.0, 0.0)
    )
    return replace(made, emission=s.choice("lit", (0.0, 0.3, 0.5)))


def outdoors(s: Style) -> Material:
    """Return the view through a window: sky over greenery or roofs."""
    tone = linear(s.uniform("hue", 0.54, 0.61), s.uniform("saturation", 0.25, 0.6), s.uniform("lightness", 0.62, 0.78))
    return Material(tone, "outdoors", emission=s.uniform("light", 0.6, 0.75), gloss=0.1)


def screen(s: Style) -> Material:
    """Return a screen, on or off."""
    lit = s.chance("lit", 0.45)
    tone = linear(
        s.uniform("hue", 0.5, 0.68),
        s.uniform("saturation", 0.1, 0.55),
        s.uniform("on", 0.35, 0.6) if lit else s.uniform("off", 0.03, 0.07),
    )
    return Material(tone, "screen", 0.3, gloss=0.7, emission=0.45 if lit else 0.0)


def picture(s: Style) -> Material:
    """Return a picture."""
    return toned(s, (*PAINTS, *CLOTHS, (0.57, 0.4, 0.55)), "picture", (0.3, 0.3), (0.05, 0.15))


def label(s: Style) -> Material:
    """Return the printed label of a product."""
    return toned(s, (*WHITES, *GLAZES, *PLASTICS), "label", (0.3, 0.3), (0.05, 0.3))


def display(s: Style) -> Material:
    """Luminous digits."""
    tone = s.choice("tone", ((0.0, 0.8, 0.5), (0.36, 0.7, 0.5), (0.52, 0.7, 0.55), (0.1, 0.8, 0.55)))
    return Material(linear(*tone), emission=0.6, gloss=0.0)


def glow(s: Style) -> Material:
    """Return a flame or a bulb."""
    return Material(linear(s.uniform("hue", 0.09, 0.13), 0.7, 0.8), emission=s.choice("lit", (0.0, 0.6, 0.8)), gloss=0.0)


def glass(s: Style) -> Material:
    """Clear glass with a slight tint."""
    tone = linear(s.uniform("hue", 0.35, 0.6), s.uniform("saturation", 0.05, 0.2), s.uniform("lightness", 0.72, 0.86))
    return Material(tone, gloss=s.uniform("gloss", 0.97, 1.0), clear=True)


def mirror(s: Style) -> Material:
    """Return a mirror: silvered glass, clear or slightly tinted."""
    return Material(linear(s.fraction("hue"), s.uniform("saturation", 0.0, 0.15), s.uniform("lightness", 0.5, 0.85)), gloss=1.0)


def floor(s: Style) -> Material:
    """Return a floor: boards, tiles, stone or carpet."""
    kind = s.choice("kind", ("wood", "wood", "wood", "tiles", "marble", "carpet"))
    if kind == "wood":
        return toned(s, WOODS, "wood", (0.1, 0.2), (0.1, 0.3), 0.05)
    if kind == "carpet":
        return toned(
            s, ((0.1, 0.16, 0.66), (0.6, 0.04, 0.55), (0.09, 0.16, 0.48), (0.58, 0.14, 0.45)), "fabric", (0.03, 0.03), (0.0, 0.0)
        )
    tones: tuple[Tone, ...] = ((0.1, 0.14, 0.74), (0.6, 0.04, 0.66), (0.6, 0.05, 0.46), (0.09, 0.1, 0.82), (0.5, 0.08, 0.6))
    if kind == "tiles":
        tones += ((0.05, 0.32, 0.48), (0.6, 0.06, 0.28), (0.08, 0.24, 0.6))
    return toned(s, tones, kind, (0.25, 0.5), (0.2, 0.42))
