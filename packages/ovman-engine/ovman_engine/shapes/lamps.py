"""Lamps, candles, switches."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.part import Part, about, column, lathe, rod, span
from ovman_engine.shapes.style import Style
from ovman_engine.shapes.subject import Subject


def shade(
    radius: float, low: float, high: float, style: Style, stretch: float = 1.0, x: float = 0.0, z: float = 0.0
) -> Iterator[Part]:
    """Yield an open lampshade between two heights with a bulb within: drum, cone, bell or globe."""
    form = style.choice("shade", ("drum", "cone", "cone", "bell", "globe"))
    wall = 0.004
    if form == "globe":
        radius_y = (high - low) / 2
        yield Part("ellipsoid", (x, low + radius_y, z), (2 * radius, 2 * radius_y, 2 * radius * stretch), slot="glow")
        return
    head = {"drum": 0.94, "cone": style.uniform("cone", 0.45, 0.72), "bell": 0.42}[form]
    waist = (0.5 * (1 + head), 0.5) if form != "bell" else (0.62, 0.42)
    outer = [(radius, low), (waist[0] * radius, low + waist[1] * (high - low)), (head * radius, high)]
    inner = [(r - wall, y) for r, y in reversed(outer)]
    yield lathe([*outer, *inner, outer[0]], x, z, "glow", stretch=(1.0, stretch), solid=False)
    yield span(
        (x - radius * 0.96, low, z - radius * stretch * 0.96),
        (x + radius * 0.96, high, z + radius * stretch * 0.96),
        kind="frustum",
        ratio=head,
        drawn=False,
    )
    bulb = min(0.05, 0.4 * radius)
    yield Part("ellipsoid", (x, (low + high) / 2, z), (bulb, 1.3 * bulb, bulb), slot="glow", solid=False)
    if style.chance("bands", 0.5):
        for y, r in ((low, radius), (high - 0.008, head * radius)):
            yield span(
                (x - r, y, z - r * stretch), (x + r, y + 0.008, z + r * stretch), "trim", kind="torus", ratio=0.06, solid=False
            )


def desk_lamp(s: Subject) -> Iterator[Part]:
    """Yield a desk lamp."""
    st = s.style
    jointed = s.elongation > 1.35
    if jointed:
        yield from _jointed(s)
        return
    radius = min(s.x, s.z)
    low = s.h * st.uniform("shade low", 0.5, 0.64)
    foot = st.uniform("foot", 0.5, 0.75) * radius
    stem = st.choice("stem", ("rod", "vase", "gourd", "column"))
    if stem == "rod":
        yield lathe([(0, 0), (foot, 0), (foot, 0.012), (0.3 * foot, 0.028), (0, 0.028)], slot="main")
        yield column(0, 0, 0.02, low + 0.3 * (s.h - low), 0.009, "main")
    else:
        profiles = {
            "vase": [(0.55, 0), (0.6, 0.05), (0.95, 0.45), (0.7, 0.75), (0.3, 0.9), (0.25, 1.0)],
            "gourd": [(0.6, 0), (0.95, 0.2), (0.9, 0.38), (0.5, 0.55), (0.7, 0.72), (0.5, 0.9), (0.2, 1.0)],
            "column": [(0.9, 0), (0.9, 0.08), (0.5, 0.12), (0.45, 0.85), (0.55, 0.9), (0.3, 1.0)],
        }
        yield lathe([(0, 0), *((r * foot, y * low) for r, y in profiles[stem]), (0, low)], slot="main")
        yield column(0, 0, low, low + 0.3 * (s.h - low), 0.008, "metal", solid=False)
    yield from shade(s.x, low, s.h, st, s.z / s.x)


def _jointed(s: Subject) -> Iterator[Part]:
    """Yield a work lamp: base, two arms, a head that looks down."""
    along_x = s.along_x
    reach, across = (s.x, s.z) if along_x else (s.z, s.x)
    foot = min(across, 0.5 * reach + 0.02)

    def at(u: float, y: float, v: float = 0.0) -> np.ndarray:
        return np.array([u, y, v] if along_x else [v, y, u])

    base = -reach + foot
    yield Part("cylinder", at(base, 0.012), np.abs(at(2 * foot, 0.024, 2 * across)), slot="main")
    elbow = at(-reach + 0.02, 0.6 * s.h)
    head = at(reach - 0.55 * foot - 0.02, s.h - 0.35 * foot)
    yield rod(at(base, 0.02), elbow, 0.008, "metal")
    yield rod(elbow, head, 0.008, "metal")
    for point in (at(base, 0.03), elbow, head):
        yield Part("ellipsoid", point, (0.03, 0.03, 0.03), slot="metal", solid=False)
    drop = np.array(head - at(reach - 0.2 * foot, s.h - 1.5 * foot))
    axis = drop / np.linalg.norm(drop)
    wide = min(across, 0.9 * foot)
    yield rod(head + 0.02 * axis - 1.1 * foot * axis, head + 0.02 * axis, wide, "second", kind="frustum", ratio=0.45)
    yield Part("ellipsoid", head - 1.05 * foot * axis, (1.1 * wide, 0.5 * wide, 1.1 * wide), slot="glow", solid=False)


def floor_lamp(s: Subject) -> Iterator[Part]:
    """Yield a floor lamp."""
    st = s.style
    radius = min(s.x, s.z)
    form = st.choice("form", ("straight", "straight", "tripod", "uplight", "column"))
    low = s.h * st.uniform("shade low", 0.76, 0.84)
    if form == "column":
        yield span((-s.x, 0, -s.z), (s.x, 0.03, s.z), "main", kind=st.choice("foot", ("box", "cylinder")))
        wide = st.uniform("column", 0.5, 0.8)
        yield span(
            (-wide * s.x, 0.05, -wide * s.z), (wide * s.x, s.h, wide * s.z), "glow", kind=st.choice("paper", ("box", "cylinder"))
        )
        for i in range(6):
            y = 0.05 + (s.h - 0.06) * i / 5
            yield span(
                (-wide * s.x - 0.004, y, -wide * s.z - 0.004),
                (wide * s.x + 0.004, y + 0.01, wide * s.z + 0.004),
                "trim",
                solid=False,
            )
        return
    if form == "tripod":
        hub = 0.86 * low
        for i in range(3):
            tip = about("y", 90.0 + 120.0 * i) @ [0.0, 0.0, 1.0] * [s.x * 0.85, 0, s.z * 0.85]
            yield rod((tip[0], 0, tip[2]), (0, hub, 0), 0.016, "trim")
        yield column(0, 0, hub - 0.06, low + 0.2 * (s.h - low), 0.018, "metal")
    else:
        foot = st.uniform("foot", 0.5, 0.75) * radius
        yield lathe([(0, 0), (foot, 0), (foot, 0.02), (0.25 * foot, 0.045), (0, 0.045)], slot="main")
        yield column(0, 0, 0.03, low + 0.3 * (s.h - low), st.uniform("pole", 0.01, 0.018), "main")
        if st.chance("reading arm", 0.25):
            yield rod((0, 0.62 * s.h, 0), (0.6 * radius, 0.7 * s.h, 0), 0.008, "metal", solid=False)
            yield rod(
                (0.6 * radius, 0.6 * s.h, 0),
                (0.6 * radius, 0.71 * s.h, 0),
                0.06,
                "second",
                kind="frustum",
                ratio=0.5,
                solid=False,
            )
    if form == "uplight":
        r = s.x
        low = s.h - 0.55 * r
        yield lathe(
            [
                (0, low),
                (0.35 * r, low + 0.02),
                (0.85 * r, low + 0.3 * r),
                (r, s.h),
                (0.96 * r, s.h),
                (0.3 * r, low + 0.06),
                (0, low + 0.05),
            ],
            slot="second",
            stretch=(1.0, s.z / s.x),
        )
        yield Part("ellipsoid", (0, low + 0.2 * r, 0), (0.5 * r, 0.3 * r, 0.5 * r), slot="glow", solid=False)
    else:
        yield from shade(s.x, low, s.h, st, s.z / s.x)


def candle(s: Subject) -> Iterator[Part]:
    """Yield a candle."""
    radius = min(s.x, s.z)
    top = 0.86 * s.h
    wax = [(0, 0), (radius, 0), (radius, top * 0.97), (radius * 0.93, top), (radius * 0.6, top * 0.95), (0, top * 0.94)]
    yield lathe(wax, slot="main", stretch=(s.x / radius, s.z / radius))
    yield column(0, 0, top * 0.9, top + 0.03 * s.h, max(0.0012, 0.06 * radius), "dark", solid=False)
    yield Part("ellipsoid", (0, top + 0.07 * s.h, 0), (0.3 * radius, 0.14 * s.h, 0.3 * radius), slot="glow", solid=False)
    if s.style.chance("band", 0.5):
        yield span(
            (-s.x * 0.999, 0.2 * s.h, -s.z * 0.999),
            (s.x * 0.999, 0.5 * s.h, s.z * 0.999),
            "accent",
            kind="torus",
            ratio=0.08,
            solid=False,
        )


def light_switch(s: Subject) -> Iterator[Part]:
    """Yield a light switch."""
    plate = 0.4 * s.d
    yield span((-s.x, 0, -s.z), (s.x, s.h, -s.z + plate), "main", bevel=0.2 * plate)
    count = 1 if s.w < 0.13 else 2 if s.w < 0.19 else 3
    wide = s.w / count
    for i in range(count):
        x = -s.x + wide * (i + 0.5)
        half = min(0.3 * wide, 0.028)
        if s.style.chance("toggle", 0.5):
            yield Part(
                "box",
                (x, 0.52 * s.h, -s.z + 0.5 * (plate + s.d)),
                (0.4 * half, 0.14 * s.h, s.d - plate),
                about("x", -8.0),
                "second",
                solid=False,
            )
            yield span(
                (x - half * 0.6, 0.38 * s.h, -s.z), (x + half * 0.6, 0.64 * s.h, -s.z + plate * 1.15), "second", solid=False
            )
        else:
            yield span((x - half, 0.22 * s.h, -s.z), (x + half, 0.5 * s.h, -s.z + 0.7 * s.d), "second", bevel=0.002, solid=False)
            yield Part(
                "box",
                (x, 0.64 * s.h, -s.z + 0.55 * s.d),
                (2 * half, 0.29 * s.h, 0.8 * s.d),
                about("x", 4.0),
                "second",
                solid=False,
            )


FORMS = {"DeskLamp": desk_lamp, "FloorLamp": floor_lamp, "Candle": candle, "LightSwitch": light_switch}
