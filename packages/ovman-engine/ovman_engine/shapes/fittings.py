"""Taps, shower heads, towel rails and paper hangers. The wall is at -z."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.part import Part, about, bar, column, rod, span, tube
from ovman_engine.shapes.subject import Subject


def faucet(s: Subject) -> Iterator[Part]:
    """Yield base at the back, spout over the front, one lever or two taps by width."""
    st = s.style
    radius = min(0.014, 0.14 * min(s.w, s.d, s.h))
    z = -s.z + max(2 * radius, 0.14 * s.d)
    neck = s.h - radius
    if s.h > 0.8 * s.d or st.chance("swan", 0.4):
        bend = min(0.45 * (s.z - z), 0.5 * s.h)
        path = [(0, 0, z), (0, neck - bend, z)]
        for t in np.linspace(0, np.pi, 9)[1:]:
            path.append((0, neck - bend + bend * np.sin(t), z + (s.z - radius - z) / 2 * (1 - np.cos(t))))
        path.append((0, neck - bend - 0.12 * s.h, s.z - radius))
    else:
        path = [
            (0, 0, z),
            (0, 0.55 * neck, z),
            (0, 0.9 * neck, z + 0.2 * (s.z - z)),
            (0, neck, z + 0.55 * (s.z - z)),
            (0, 0.9 * neck, s.z - 1.4 * radius),
            (0, 0.72 * neck, s.z - radius),
        ]
    yield tube(path, radius, "metal", solid=False)
    yield span((-radius, 0, z - radius), (radius, s.h, s.z), drawn=False)
    yield column(0, z, 0, 0.12 * s.h, 1.7 * radius, "metal", solid=False)
    if (s.true or (s.w,))[0] > 0.16:
        half = s.x - 1.8 * radius
        yield span((-s.x, 0, z - 1.5 * radius), (s.x, 0.05 * s.h + 0.004, z + 1.5 * radius), "metal", bevel=0.003)
        for sx in (-1, 1):
            yield column(sx * half, z, 0, 0.26 * s.h, 1.3 * radius, "metal", solid=False)
            yield bar(
                (sx * half, 0.3 * s.h, z - 2 * radius),
                (sx * half, 0.32 * s.h, z + 3.2 * radius),
                1.1 * radius,
                0.9 * radius,
                "accent",
                kind="capsule",
                solid=False,
            )
    else:
        yield rod((0, 0.3 * s.h, z), (s.x - radius, 0.42 * s.h, z), 0.6 * radius, "metal", solid=False)
        yield rod((0, 0.3 * s.h, z), (-s.x + radius, 0.3 * s.h, z), 0.9 * radius, "metal", solid=False)


def shower_head(s: Subject) -> Iterator[Part]:
    """Yield a rail on the wall, an arm over the front and a rose; short ones have no rail."""
    radius = min(0.012, 0.2 * s.w)
    z = -s.z + radius + 0.005
    rose = min(s.x, 0.45 * s.d, 0.09)
    top = s.h - radius
    yield tube(
        [
            (0, 0.02 if s.h > 0.5 else 0.5 * s.h, z),
            (0, 0.86 * s.h, z),
            (0, top - 0.02, z + 0.15 * s.d),
            (0, top, 0),
            (0, top - 0.02, s.z - rose),
            (0, top - 0.05, s.z - rose),
        ],
        radius,
        "metal",
        solid=False,
    )
    yield span((-s.x, top - 0.1, s.z - 2 * rose), (s.x, top - 0.05, s.z), "metal", kind="frustum", ratio=0.5)
    yield span(
        (-0.9 * s.x, top - 0.106, s.z - 1.9 * rose),
        (0.9 * s.x, top - 0.098, s.z - 0.1 * rose),
        "dark",
        kind="cylinder",
        solid=False,
    )
    if s.h > 0.5:
        for y in (0.08 * s.h, 0.75 * s.h):
            yield rod((0, y, -s.z), (0, y, z + 0.02), 1.5 * radius, "metal", solid=False)
        yield span((-s.x, 0.1 * s.h, -s.z), (s.x, 0.1 * s.h + 0.07, -s.z + 0.04), "metal", bevel=0.01, solid=False)
        hose = [(0.4 * s.x, 0.1 * s.h, z)] + [
            (0.5 * s.x * np.sin(t * 3.1), (0.1 + 0.55 * t - 0.1 * np.sin(np.pi * t)) * s.h, z + 0.03 + 0.03 * np.sin(np.pi * t))
            for t in np.linspace(0.1, 1, 8)
        ]
        yield tube(hose, 0.5 * radius, "metal", solid=False)


def towel_holder(s: Subject) -> Iterator[Part]:
    """Yield a rail before the wall, or a ring where it is taller than wide."""
    radius = min(0.008, 0.18 * min(s.h, s.d))
    if s.h > s.w * 0.8:
        middle, half = 0.44 * s.h, min(s.x, 0.44 * s.h)
        yield Part(
            "torus",
            (0, middle, s.z - radius),
            (s.w, 2 * radius, 2 * middle),
            about("x", 90.0),
            "metal",
            solid=False,
            ratio=2 * radius / half,
        )
        yield span((-0.16 * s.w, 0.82 * s.h, -s.z), (0.16 * s.w, s.h, -s.z + 0.3 * s.d), "metal", bevel=0.003)
        yield rod((0, 0.88 * s.h, -s.z), (0, 0.88 * s.h, s.z), 1.3 * radius, "metal", solid=False)
        return
    y = s.h / 2
    yield rod((-s.x, y, s.z - 1.5 * radius), (s.x, y, s.z - 1.5 * radius), radius, "metal")
    for sx in (-1, 1):
        x = sx * (s.x - 0.03)
        yield rod((x, y, -s.z), (x, y, s.z - radius), 0.8 * radius, "metal", solid=False)
        yield Part("cylinder", (x, y, -s.z + 0.008), (min(0.05, s.h), 0.016, s.h), about("x", 90.0), "metal", solid=False)
        yield Part("ellipsoid", (x, y, s.z - 1.5 * radius), (3 * radius, 3 * radius, 3 * radius), slot="metal", solid=False)


def paper_hanger(s: Subject) -> Iterator[Part]:
    """Yield a plate on the wall and an arm along x."""
    radius = min(0.008, 0.16 * min(s.h, s.d))
    y = 0.4 * s.h
    form = s.style.chance("two posts", 0.5)
    yield span(
        (-s.x if form else -s.x * 0.2, 0, -s.z), (s.x if form else s.x * 0.2, s.h, -s.z + 0.25 * s.d), "metal", bevel=0.004
    )
    ends = (-s.x + radius, s.x - radius)
    yield rod((-s.x, y, s.z - radius), (s.x, y, s.z - radius), radius, "metal")
    for x in ends if form else (ends[0],):
        yield bar((x, y, -s.z + 0.1 * s.d), (x, y, s.z), 2 * radius, slot="metal", solid=False)
    if not form:
        yield bar((-s.x + radius, y, -s.z + 0.12 * s.d), (0, y, -s.z + 0.12 * s.d), 2 * radius, slot="metal", solid=False)


FORMS = {
    "Faucet": faucet,
    "ShowerHead": shower_head,
    "TowelHolder": towel_holder,
    "HandTowelHolder": towel_holder,
    "ToiletPaperHanger": paper_hanger,
}
