"""Bathroom fixtures, sinks and what hangs or stands beside them. Back at -z."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman.engine.shapes.fronts import closed_block, doors
from ovman.engine.shapes.part import Part, about, bar, column, lathe, rod, span, tube
from ovman.engine.shapes.subject import Subject


def toilet(s: Subject) -> Iterator[Part]:
    st = s.style
    tank = 0.26 * s.d
    seat = min(0.44, 0.46 * s.h)
    wide = min(s.w, 0.56)
    lid = 0.035
    yield span(
        (-s.x if s.w < 0.7 else -0.36, seat * 0.85, -s.z),
        (s.x if s.w < 0.7 else 0.36, s.h - lid, -s.z + tank),
        "main",
        bevel=0.025,
    )
    yield span(
        (-s.x if s.w < 0.7 else -0.37, s.h - lid, -s.z),
        (s.x if s.w < 0.7 else 0.37, s.h, -s.z + tank + 0.012),
        "main",
        bevel=0.012,
    )
    if s.w >= 0.7:
        yield span((-s.x, 0.45 * s.h, -s.z), (s.x, 0.48 * s.h, -s.z + 0.02), "metal", solid=False)
    yield Part("cylinder", (0, s.h - 0.004, -s.z + tank / 2), (0.05, 0.014, 0.05), slot="metal", solid=False)
    yield tube(
        [
            (-0.7 * wide / 2, s.h - 0.1, -s.z + tank),
            (-0.7 * wide / 2, s.h - 0.1, -s.z + tank + 0.03),
            (-0.4 * wide / 2, s.h - 0.11, -s.z + tank + 0.03),
        ],
        0.008,
        "metal",
        solid=False,
    )
    front, rear = s.z, -s.z + tank
    middle, reach = (front + rear) / 2 + 0.03, (front - rear) / 2 + 0.02
    x = min(wide / 2 * 0.86, 0.24)
    yield lathe(
        [
            (0, 0),
            (0.62 * x, 0),
            (0.66 * x, 0.02),
            (0.5 * x, 0.3 * seat),
            (0.62 * x, 0.55 * seat),
            (x, 0.92 * seat),
            (x, seat - 0.02),
            (0.82 * x, seat - 0.02),
            (0.6 * x, 0.6 * seat),
            (0, 0.52 * seat),
        ],
        0,
        middle - 0.03,
        "main",
        stretch=(1.0, reach / x),
        segments=28,
        solid=False,
    )
    yield span((-x, 0, middle - 0.03 - reach), (x, seat, middle - 0.03 + reach), drawn=False, kind="frustum", ratio=1.6)
    yield span((-0.45 * x, 0, rear - 0.02), (0.45 * x, 0.8 * seat, middle), "main", bevel=0.03)
    yield span(
        (-x, seat - 0.02, middle - 0.03 - reach),
        (x, seat, middle - 0.03 + reach),
        "second",
        kind="torus",
        ratio=0.42,
        segments=28,
        solid=False,
    )
    if st.chance("lid down", 0.5):
        yield span((-x, seat - 0.002, rear + 0.015), (x, seat + 0.018, front), "second", kind="cushion", ratio=0.5)
    else:
        yield bar(
            (0, seat, rear + 0.04),
            (0, min(s.h - 0.03, seat + 0.42), rear + 0.02),
            2 * x,
            0.018,
            "second",
            kind="box",
            bevel=0.008,
            solid=False,
        )


def _hollow_box(s: Subject, wall: float, floor: float, slot: str, bevel: float, low: float = 0.0) -> Iterator[Part]:
    """Four walls and a bottom."""
    yield span((-s.x, low, -s.z), (s.x, low + floor, s.z), slot, bevel=bevel)
    for sign in (-1, 1):
        near, far = sorted((sign * s.x, sign * (s.x - wall)))
        yield span((near, low, -s.z), (far, s.h, s.z), slot, bevel=bevel)
        near, far = sorted((sign * s.z, sign * (s.z - wall)))
        yield span((-s.x + wall * 0.5, low, near), (s.x - wall * 0.5, s.h, far), slot, bevel=bevel)


def bathtub(s: Subject) -> Iterator[Part]:
    """A hollow tub with a broad rim, rounded inner ends and, by asset, feet or an apron down to the floor."""
    wall = min(0.11, 0.14 * min(s.w, s.d))
    yield from _hollow_box(s, wall, 0.16 * s.h, "main", 0.03)
    along_x = s.along_x
    for sign in (-1, 1):
        u = sign * ((s.x if along_x else s.z) - wall)
        half = (s.z if along_x else s.x) - wall
        high = 0.8 * s.h
        start, end = ((u, 0.14 * s.h, 0), (u, high, 0)) if along_x else ((0, 0.14 * s.h, u), (0, high, u))
        size = (0.16, 2 * half) if along_x else (2 * half, 0.16)
        lean = about("z", sign * -12.0) if along_x else about("x", sign * 12.0)
        centre = (np.array(start) + np.array(end)) / 2
        yield Part("cushion", centre, (size[0], high - 0.14 * s.h, size[1]), lean, "main", solid=False, ratio=0.3)
    yield Part("cylinder", (0, 0.165 * s.h, 0), (0.06, 0.012, 0.06), slot="metal", solid=False)
    yield span((-s.x * 0.98, 0.12 * s.h, s.z - 0.003), (s.x * 0.98, 0.2 * s.h, s.z), "second", solid=False)


def basin(s: Subject) -> Iterator[Part]:
    """The hollow of a sink or tub: thin walls, bottom, drain."""
    wall = min(0.012, 0.05 * min(s.w, s.d))
    yield from _hollow_box(s, wall, min(0.015, 0.12 * s.h), "metal", 0.004)
    y = min(0.015, 0.12 * s.h)
    yield Part("cylinder", (0, y + 0.002, 0), (0.055, 0.006, 0.055), slot="dark", solid=False)


def sink(s: Subject) -> Iterator[Part]:
    """A rim around an opening; what is tall stands on a pedestal or a vanity with doors. The bowl belongs to the basin."""
    st = s.style
    bowl = min(0.16, 0.85 * s.h)
    rim = 0.022
    margin = min(0.07, 0.12 * min(s.w, s.d))
    back = min(0.11, 0.2 * s.d)
    top = s.h
    yield span((-s.x, top - rim, -s.z), (s.x, top, -s.z + back), "main", bevel=0.006)
    yield span((-s.x, top - rim, s.z - margin), (s.x, top, s.z), "main", bevel=0.006)
    for sign in (-1, 1):
        low, high = sorted((sign * s.x, sign * (s.x - margin)))
        yield span((low, top - rim, -s.z + back * 0.8), (high, top, s.z - margin * 0.8), "main", bevel=0.006)
    inner = Subject(s.type, s.w - 1.8 * margin, top - 0.004, s.d - back - 0.8 * margin, st)
    shift = (back - margin) / 2
    for part in _hollow_box(inner, 0.012, 0.012, "main", 0.003, low=top - bowl):
        yield part.but(centre=part.centre + [0, 0, shift], solid=False)
    yield Part("cylinder", (0, top - bowl + 0.013, shift), (0.05, 0.006, 0.05), slot="metal", solid=False)
    if s.h < 0.3:
        yield span(
            (-0.4 * inner.w, 0, shift - 0.4 * inner.d),
            (0.4 * inner.w, top - bowl + 0.004, shift + 0.4 * inner.d),
            "main",
            solid=False,
        )
        yield Part("box", (0, 0.002, 0), (0.3 * s.w, 0.004, 0.3 * s.d), slot="main", solid=False)
        return
    if s.w > 0.5 and st.chance("vanity", 0.6) or s.inserts:
        yield span((-s.x + 0.01, 0.06, -s.z), (s.x - 0.01, top - bowl, s.z - 0.03), "second", bevel=0.004)
        yield span((-s.x + 0.01, top - bowl, s.z - 0.045), (s.x - 0.01, top - rim, s.z - 0.03), "second", solid=False)
        for sign in (-1, 1):
            low, high = sorted((sign * (s.x - 0.01), sign * (s.x - 0.025)))
            yield span((low, top - bowl, -s.z), (high, top - rim, s.z - 0.03), "second", solid=False)
        yield span((-s.x + 0.03, 0, -s.z), (s.x - 0.03, 0.06, s.z - 0.08), "dark", solid=False)
        if s.inserts:
            yield from closed_block(s, top - bowl)
        else:
            yield from doors((-s.x + 0.02, s.x - 0.02, 0.07, top - bowl - 0.01), s.z - 0.03, st, 2)
    else:
        r = min(0.11, 0.24 * s.w)
        yield lathe(
            [
                (0, 0),
                (1.3 * r, 0),
                (1.3 * r, 0.04),
                (0.75 * r, 0.15),
                (0.7 * r, 0.6 * s.h),
                (1.2 * r, top - bowl),
                (0, top - bowl),
            ],
            0,
            min(0, -s.z + 1.6 * r),
            "main",
        )
        yield column(
            0, shift, top - bowl - 0.05, top - bowl + 0.006, 0.3 * inner.w, "main", kind="frustum", ratio=1.5, solid=False
        )


def faucet(s: Subject) -> Iterator[Part]:
    """Base at the back, spout over the front, one lever or two taps by width."""
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
    """A rail on the wall, an arm over the front and a rose; short ones have no rail."""
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


def shower_door(s: Subject) -> Iterator[Part]:
    """A framed pane along its longer side; where the box is deep, two panes that meet at a corner of the stall."""
    if min(s.w, s.d) < 0.3:
        yield from _pane(s, s.type == "ShowerDoor")
        return
    side = 1 if s.style.chance("corner", 0.5) else -1
    for w, d, x, z in ((s.w, 0.05, 0.0, s.z - 0.025), (0.05, s.d, side * (s.x - 0.025), 0.0)):
        for part in _pane(Subject(s.type, w, s.h, d, s.style), False):
            yield part.but(centre=part.centre + [x, 0, z])


def _pane(s: Subject, grip: bool) -> Iterator[Part]:
    along_x = s.along_x
    half, thick = (s.x, s.z) if along_x else (s.z, s.x)
    bars = 0.035

    def block(u0: float, u1: float, y0: float, y1: float, share: float, slot: str, **fields: object) -> Part:
        v = share * thick
        low, high = ((u0, y0, -v), (u1, y1, v)) if along_x else ((-v, y0, u0), (v, y1, u1))
        return span(low, high, slot, **fields)

    yield block(-half, half, 0, bars, 1.0, "metal", solid=False)
    yield block(-half, half, s.h - bars, s.h, 1.0, "metal", solid=False)
    for sign in (-1, 1):
        near, far = sorted((sign * half, sign * (half - bars)))
        yield block(near, far, 0, s.h, 0.9, "metal", solid=False)
    share = min(1.0, 0.004 / thick)
    yield block(-half + bars, half - bars, bars, s.h - bars, share, "glass", solid=False)
    yield block(-half, half, 0, s.h, min(1.0, 0.03 / thick), "glass", drawn=False)
    if grip:
        u = half - 2.4 * bars
        yield block(u - 0.012, u + 0.012, 0.42 * s.h, 0.6 * s.h, 0.95, "metal", bevel=0.004, solid=False)


def towel_holder(s: Subject) -> Iterator[Part]:
    """A rail before the wall, or a ring where it is taller than wide."""
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
    """A plate on the wall and an arm along x."""
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


def plunger(s: Subject) -> Iterator[Part]:
    cup = 0.22 * s.h
    yield lathe(
        [
            (0, 0.35 * cup),
            (0.8 * s.x, 0),
            (s.x, 0),
            (0.95 * s.x, 0.35 * cup),
            (0.6 * s.x, 0.75 * cup),
            (0.22 * s.x, cup),
            (0, cup),
        ],
        slot="rubber",
        stretch=(1.0, s.z / s.x),
    )
    yield column(0, 0, 0.9 * cup, s.h - 0.02, 0.012, "main")
    yield Part("ellipsoid", (0, s.h - 0.018, 0), (0.034, 0.036, 0.034), slot="main", solid=False)


def scrub_brush(s: Subject) -> Iterator[Part]:
    """A toilet brush in its holder."""
    holder = 0.34 * s.h
    yield lathe(
        [
            (0, 0),
            (0.9 * s.x, 0),
            (s.x, 0.1 * holder),
            (0.82 * s.x, holder),
            (0.74 * s.x, holder),
            (0.8 * s.x, 0.1 * holder),
            (0, 0.08 * holder),
        ],
        slot="main",
        stretch=(1.0, s.z / s.x),
    )
    yield column(0, 0, 0.3 * holder, 1.08 * holder, 0.55 * min(s.x, s.z), "pale", kind="ellipsoid", solid=False)
    yield column(0, 0, 0.8 * holder, 0.97 * s.h, 0.011, "metal")
    yield column(0, 0, 0.82 * s.h, s.h, 0.017, "second", kind="capsule", solid=False)


def soap_bar(s: Subject) -> Iterator[Part]:
    yield span((-s.x, 0, -s.z), (s.x, s.h, s.z), "main", kind="cushion", ratio=0.4)
    yield span(
        (-0.6 * s.x, 0.9 * s.h, -0.6 * s.z), (0.6 * s.x, 0.995 * s.h, 0.6 * s.z), "second", kind="cushion", ratio=0.4, solid=False
    )


def sponge(s: Subject) -> Iterator[Part]:
    yield span((-s.x, 0, -s.z), (s.x, 0.74 * s.h, s.z), "main", bevel=0.14 * s.h)
    yield span((-s.x, 0.7 * s.h, -s.z), (s.x, s.h, s.z), "second", bevel=0.08 * s.h)


FORMS = {
    "Toilet": toilet,
    "Bathtub": bathtub,
    "BathtubBasin": basin,
    "Sink": sink,
    "SinkBasin": basin,
    "Faucet": faucet,
    "ShowerHead": shower_head,
    "ShowerDoor": shower_door,
    "ShowerGlass": shower_door,
    "TowelHolder": towel_holder,
    "HandTowelHolder": towel_holder,
    "ToiletPaperHanger": paper_hanger,
    "Plunger": plunger,
    "ScrubBrush": scrub_brush,
    "SoapBar": soap_bar,
    "DishSponge": sponge,
}
