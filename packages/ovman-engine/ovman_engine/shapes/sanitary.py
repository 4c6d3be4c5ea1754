"""Toilets, tubs and sinks. Back at -z."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.fronts import closed_block, doors
from ovman_engine.shapes.part import Part, about, bar, column, lathe, span, tube
from ovman_engine.shapes.subject import Subject


def toilet(s: Subject) -> Iterator[Part]:
    """Yield a toilet: foot, bowl, seat and tank."""
    st = s.style
    tank = (0.26 if s.w < 0.7 else 0.42) * s.d
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
    """Yield a hollow tub with a broad rim, rounded inner ends and, by asset, feet or an apron down to the floor."""
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
    """Yield the hollow of a sink or tub: thin walls, bottom, drain."""
    wall = min(0.012, 0.05 * min(s.w, s.d))
    yield from _hollow_box(s, wall, min(0.015, 0.12 * s.h), "metal", 0.004)
    y = min(0.015, 0.12 * s.h)
    yield Part("cylinder", (0, y + 0.002, 0), (0.055, 0.006, 0.055), slot="dark", solid=False)


def sink(s: Subject) -> Iterator[Part]:
    """Yield a rim around an opening; a tall sink stands on a pedestal or a vanity with doors. The bowl belongs to the basin."""
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


FORMS = {
    "Toilet": toilet,
    "Bathtub": bathtub,
    "BathtubBasin": basin,
    "Sink": sink,
    "SinkBasin": basin,
}
