"""Colour and texture of an instance's slots, drawn from a hash of its asset and its scene, never from its type.

Colour must not give the category away: every slot that makes up a body draws from the same home palette, whatever the object is.
The scene is part of the key because many assets occur in all scenes; were they painted alike everywhere, colour would name them.
The type is read only to let what is built in match: cabinet fronts, window frames and counters of one scene are of one make.
"""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from ovman.engine.floorplan import FloorPlan, SimObject
from ovman.engine.shapes import surroundings
from ovman.engine.shapes.style import Style

MAKES = {
    "Cabinet": "cabinetry",
    "Drawer": "cabinetry",
    "CounterTop": "counter",
    "Shelf": "shelves",
    "Window": "windows",
    "Blinds": "blinds",
    "Curtains": "curtains",
    "StoveBurner": "stove",
    "StoveKnob": "stove",
    "ShowerDoor": "shower",
    "ShowerGlass": "shower",
    "SinkBasin": "basins",
    "BathtubBasin": "basins",
}
"""Types without assets of their own, and the make that all of a scene share."""


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


def _wood(s: Style) -> Material:
    hue, tone = s.uniform("hue", 0.045, 0.11), s.uniform("lightness", 0.2, 0.66)
    return Material(
        linear(hue, s.uniform("saturation", 0.22, 0.5), tone),
        "wood",
        s.uniform("scale", 0.14, 0.4),
        gloss=s.uniform("gloss", 0.05, 0.35),
    )


def _white(s: Style) -> Material:
    return Material(
        linear(s.fraction("hue"), s.uniform("saturation", 0.0, 0.22), s.uniform("lightness", 0.72, 0.9)),
        gloss=s.uniform("gloss", 0.05, 0.5),
    )


def _grey(s: Style) -> Material:
    return Material(
        linear(s.fraction("hue"), s.uniform("saturation", 0.0, 0.12), s.uniform("lightness", 0.1, 0.55)),
        gloss=s.uniform("gloss", 0.05, 0.5),
    )


def _muted(s: Style) -> Material:
    return Material(
        linear(s.fraction("hue"), s.uniform("saturation", 0.12, 0.34), s.uniform("lightness", 0.3, 0.68)),
        gloss=s.uniform("gloss", 0.03, 0.45),
    )


def _deep(s: Style) -> Material:
    return Material(
        linear(s.fraction("hue"), s.uniform("saturation", 0.22, 0.5), s.uniform("lightness", 0.18, 0.36)),
        gloss=s.uniform("gloss", 0.03, 0.5),
    )


def _vivid(s: Style) -> Material:
    return Material(
        linear(s.fraction("hue"), s.uniform("saturation", 0.42, 0.62), s.uniform("lightness", 0.38, 0.56)),
        gloss=s.uniform("gloss", 0.05, 0.5),
    )


def _stone(s: Style) -> Material:
    tone = linear(s.fraction("hue"), s.uniform("saturation", 0.02, 0.16), s.uniform("lightness", 0.25, 0.82))
    return Material(tone, "marble", s.uniform("scale", 0.25, 0.7), gloss=s.uniform("gloss", 0.3, 0.7))


ALLOYS = ((0.6, 0.03, 0.62), (0.58, 0.04, 0.45), (0.12, 0.42, 0.5), (0.06, 0.4, 0.45), (0.6, 0.03, 0.16), (0.1, 0.05, 0.82))
"""Hue, saturation and lightness of the metals in a home."""


def _metal(s: Style) -> Material:
    """Steel, chrome, brass, copper, black or white metal, or lacquer."""
    if s.chance("lacquer", 0.25):
        tone = linear(s.fraction("hue"), s.uniform("saturation", 0.1, 0.45), s.uniform("lightness", 0.2, 0.7))
        return Material(tone, gloss=s.uniform("gloss", 0.4, 0.7))
    hue, saturation, lightness = s.choice("alloy", ALLOYS)
    tone = linear(hue, saturation, min(0.92, lightness * s.uniform("lightness", 0.7, 1.15)))
    return Material(tone, "metal_brushed", 0.1, gloss=s.uniform("gloss", 0.45, 0.85))


PALETTE: tuple[Callable[[Style], Material], ...] = (
    *(_wood,) * 6,
    *(_white,) * 5,
    *(_grey,) * 4,
    *(_muted,) * 9,
    *(_deep,) * 3,
    _vivid,
    _stone,
    _metal,
)
"""What homes are made of, by how often."""
PATTERNS: tuple[tuple[str, float, float], ...] = (
    *(("plain", 0.2, 0.2),) * 16,
    *(("fabric", 0.01, 0.03),) * 9,
    *(("weave", 0.006, 0.016),) * 5,
    ("stripes", 0.03, 0.09),
    ("checker", 0.03, 0.07),
    ("print", 0.05, 0.1),
)
"""Patterns of what is not wood, stone or metal, by how often, with the range of their periods in metres."""


def _body(s: Style) -> Material:
    """Any material of the house. Painted things may carry a pattern."""
    made = s.choice("family", PALETTE)(s)
    if made.texture == "plain":
        texture, low, high = s.choice("pattern", PATTERNS)
        made = replace(made, texture=texture, scale_m=s.uniform("scale", low, high))
        if texture != "plain":
            made = replace(made, gloss=0.3 * made.gloss)
    return made


def _accent(s: Style) -> Material:
    return s.choice("family", (_muted, _vivid, _white, _deep, _muted, _wood))(s)


def _dark(s: Style) -> Material:
    return Material(
        linear(s.fraction("hue"), s.uniform("saturation", 0.0, 0.15), s.uniform("lightness", 0.06, 0.2)),
        gloss=s.uniform("gloss", 0.1, 0.6),
    )


def _pale(s: Style) -> Material:
    return Material(
        linear(s.uniform("hue", 0.05, 0.2), s.uniform("saturation", 0.05, 0.2), s.uniform("lightness", 0.78, 0.9)),
        s.choice("texture", ("plain", "fabric")),
        0.04,
    )


def _leaf(s: Style) -> Material:
    """Foliage as it comes: green, olive, blue-green, red, purple, straw."""
    low, high = s.choice(
        "kind", ((0.2, 0.38),) * 4 + ((0.12, 0.2),) * 2 + ((0.38, 0.5), (0.94, 1.06), (0.94, 1.06), (0.76, 0.88), (0.08, 0.13))
    )
    tone = linear(s.uniform("hue", low, high) % 1.0, s.uniform("saturation", 0.18, 0.52), s.uniform("lightness", 0.2, 0.48))
    return Material(tone, "plain", 0.05, gloss=s.uniform("gloss", 0.05, 0.3))


def _soil(s: Style) -> Material:
    return Material(
        linear(s.uniform("hue", 0.04, 0.1), s.uniform("saturation", 0.1, 0.35), s.uniform("lightness", 0.1, 0.4)),
        "fabric",
        0.02,
        gloss=0.0,
    )


def _glow(s: Style) -> Material:
    """A lampshade: any cloth or paper, lit or not."""
    tone = linear(s.fraction("hue"), s.uniform("saturation", 0.05, 0.45), s.uniform("lightness", 0.3, 0.9))
    return Material(tone, s.choice("texture", ("plain", "fabric")), 0.03, emission=s.choice("lit", (0.0, 0.3, 0.55)), gloss=0.0)


def _sky(s: Style) -> Material:
    return Material(
        linear(s.uniform("hue", 0.53, 0.62), s.uniform("saturation", 0.15, 0.5), s.uniform("lightness", 0.78, 0.9)),
        emission=s.uniform("light", 0.75, 1.0),
        gloss=0.3,
    )


def _screen(s: Style) -> Material:
    lit = s.chance("lit", 0.45)
    tone = linear(
        s.fraction("hue"),
        s.uniform("saturation", 0.1, 0.5),
        s.uniform("lightness", 0.3, 0.6) if lit else s.uniform("off", 0.04, 0.1),
    )
    return Material(tone, "screen" if lit else "plain", 0.3, gloss=0.75, emission=0.5 if lit else 0.0)


def _picture(s: Style) -> Material:
    tone = s.choice("family", (_muted, _muted, _deep, _white, _vivid))(s).colour
    return Material(tone, s.choice("texture", ("picture", "picture", "print")), 0.3, gloss=0.1)


def _pages(s: Style) -> Material:
    return Material(
        linear(s.uniform("hue", 0.08, 0.16), s.uniform("saturation", 0.05, 0.25), s.uniform("lightness", 0.75, 0.9)),
        "pages",
        0.01,
        gloss=0.0,
    )


def _glass(s: Style) -> Material:
    return Material(
        linear(s.uniform("hue", 0.3, 0.65), s.uniform("saturation", 0.05, 0.25), s.uniform("lightness", 0.6, 0.82)), gloss=0.9
    )


def _mirror(s: Style) -> Material:
    """Silvered glass, clear or tinted, in the light that the room happens to throw on it."""
    return Material(linear(s.fraction("hue"), s.uniform("saturation", 0.0, 0.25), s.uniform("lightness", 0.25, 0.85)), gloss=1.0)


def _floor(s: Style) -> Material:
    """Boards, tiles, stone or carpet in the tones that floors have."""
    kind = s.choice("kind", ("wood", "wood", "wood", "tiles", "marble", "carpet"))
    if kind == "wood":
        tone = linear(s.uniform("hue", 0.05, 0.1), s.uniform("saturation", 0.2, 0.45), s.uniform("lightness", 0.28, 0.58))
        return Material(tone, "wood", s.uniform("scale", 0.1, 0.2), gloss=s.uniform("gloss", 0.1, 0.3))
    tone = linear(s.uniform("hue", 0.05, 0.65), s.uniform("saturation", 0.03, 0.16), s.uniform("lightness", 0.42, 0.74))
    if kind == "carpet":
        return Material(tone, "fabric", 0.03, gloss=0.0)
    return Material(tone, kind, s.uniform("scale", 0.25, 0.5), gloss=s.uniform("gloss", 0.25, 0.45))


SLOTS: Mapping[str, Callable[[Style], Material]] = MappingProxyType(
    {
        "main": _body,
        "second": _body,
        "cloth": _body,
        "cloth_second": _body,
        "trim": lambda s: s.choice("family", (_wood, _wood, _metal, _grey, _white, _muted))(s),
        "accent": _accent,
        "metal": _metal,
        "dark": _dark,
        "pale": _pale,
        "leaf": _leaf,
        "leaf_second": _leaf,
        "soil": _soil,
        "glow": _glow,
        "sky": _sky,
        "screen": _screen,
        "picture": _picture,
        "pages": _pages,
        "glass": _glass,
        "mirror": _mirror,
        "rubber": lambda s: s.choice("family", (_deep, _grey, _muted))(s),
    }
)
RELATED = {"second": ("main", 0.6), "cloth_second": ("cloth", 0.75), "leaf_second": ("leaf", 1.0)}
"""Slots that are often of the same stuff as another: (which, how often). They then differ a little in lightness."""
_SHADE = 0.16
_APART = 0.1
"""How far instances of one asset differ in lightness within a scene."""
_KEPT = 8
_REPEATS: OrderedDict[int, tuple[FloorPlan, Counter]] = OrderedDict()


def _shaded(material: Material, share: float) -> Material:
    return replace(material, colour=np.clip(material.colour * (1.0 + share), 0.0, 0.95))


def _painted(key: str) -> dict[str, Material]:
    made: dict[str, Material] = {}
    whole = Style(key)
    for slot, draw in SLOTS.items():
        style = Style(f"{key}|{slot}")
        other, often = RELATED.get(slot, ("", 0.0))
        if other and whole.chance(f"{slot} as {other}", often):
            made[slot] = _shaded(made[other], style.choice("sign", (-1, 1)) * style.uniform("shade", 0.5, 1.5) * _SHADE)
        else:
            made[slot] = replace(draw(style), seed=style.integer("seed") % 2**31)
    return made


def _repeats(plan: FloorPlan) -> Counter:
    kept, found = _REPEATS.get(id(plan), (None, Counter()))
    if kept is not plan:
        found = Counter(o.asset_id for o in plan.objects if o.asset_id)
        _REPEATS[id(plan)] = (plan, found)
        while len(_REPEATS) > _KEPT:
            _REPEATS.popitem(last=False)
    return found


def make(obj: SimObject, plan: FloorPlan) -> str:
    """Key of the finish of `obj`: its asset, the furniture it is set into, the scene's make, or its name."""
    if obj.asset_id:
        return f"{plan.name}|{obj.asset_id}"
    owner = surroundings.host(obj, plan)
    if owner is not None:
        return make(owner, plan)
    return f"{plan.name}|{MAKES.get(obj.type, obj.name)}"


def palette(obj: SimObject, plan: FloorPlan) -> Mapping[str, Material]:
    """Material of every slot of `obj`. Deterministic in (scene, asset, and instance where its asset repeats in the scene)."""
    made = _painted(make(obj, plan))
    if obj.type == "Floor":
        style = Style(f"{plan.name}|floor")
        made["main"] = replace(_floor(style), seed=style.integer("seed") % 2**31)
    if obj.type == "CounterTop":
        cabinetry = _painted(f"{plan.name}|{MAKES['Cabinet']}")
        made["second"] = cabinetry["main"]
    if obj.asset_id and _repeats(plan)[obj.asset_id] > 1:
        own = Style(f"{plan.name}|{obj.name}")
        share = own.uniform("apart", -_APART, _APART)
        made = {
            slot: replace(_shaded(m, share), seed=own.integer(slot) % 2**31) if m.emission == 0.0 else m
            for slot, m in made.items()
        }
    return MappingProxyType(made)
