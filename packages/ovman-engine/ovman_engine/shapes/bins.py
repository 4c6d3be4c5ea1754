"""Hampers, garbage cans, bags and boxes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.part import Part, about, bar, column, lathe, span, tube
from ovman_engine.shapes.subject import Subject


def hamper(s: Subject) -> Iterator[Part]:
    """Yield a laundry basket: woven walls that widen upwards, a rim and a lid or washing heaped in it."""
    st = s.style
    round_form = abs(s.w - s.d) < 0.08
    lid = st.chance("lid", 0.5)
    high = s.h - (0.03 if lid else 0.07)
    if round_form:
        yield _can(s, 0.82, high, 0.02)
    else:
        yield from _tub(s, 0.9, high, 0.02, "main")
    yield span(
        (-s.x, high - 0.035, -s.z), (s.x, high, s.z), "trim", bevel=0.01, solid=False, kind="cylinder" if round_form else "box"
    )
    if lid:
        yield span(
            (-s.x * 0.98, high, -s.z * 0.98),
            (s.x * 0.98, s.h, s.z * 0.98),
            "second",
            kind="cylinder" if round_form else "box",
            bevel=0.01,
        )
    else:
        yield span((-s.x * 0.8, high - 0.1, -s.z * 0.8), (s.x * 0.8, s.h, s.z * 0.8), "cloth", kind="ellipsoid")
    for sx in (-1, 1):
        yield span(
            (sx * s.x * 0.97 - 0.006, 0.7 * s.h, -0.06),
            (sx * s.x * 0.97 + 0.006, 0.7 * s.h + 0.03, 0.06),
            "dark",
            bevel=0.004,
            solid=False,
        )


def _can(s: Subject, taper: float, high: float, wall: float, slot: str = "main") -> Part:
    radius = s.x
    profile = [(0, 0), (taper * radius, 0), (radius, high), (radius - wall, high), (taper * radius - wall, wall), (0, wall)]
    return lathe(profile, slot=slot, stretch=(1.0, s.z / s.x))


def _tub(s: Subject, taper: float, high: float, wall: float, slot: str) -> Iterator[Part]:
    """Four leaning walls and a bottom."""
    x, z = taper * s.x, taper * s.z
    yield span((-x, 0, -z), (x, wall, z), slot, bevel=0.002)
    lean_x, lean_z = (1 - taper) * s.x, (1 - taper) * s.z
    for sign in (-1, 1):
        foot, head = (sign * (x - wall / 2), 0, 0), (sign * (x - wall / 2 + lean_x), high, 0)
        yield bar(foot, head, wall, 2 * s.z - lean_z, slot)
        near, far = (0, 0, sign * (z - wall / 2)), (0, high, sign * (z - wall / 2 + lean_z))
        yield bar(near, far, 2 * s.x - lean_x, wall, slot)


def garbage_can(s: Subject) -> Iterator[Part]:
    """Yield a garbage can."""
    st = s.style
    form = st.choice("form", ("open", "open", "pedal", "swing"))
    round_form = abs(s.w - s.d) < 0.06 * (s.w + s.d)
    taper = st.uniform("taper", 0.7, 0.92)
    body = s.h if form == "open" else 0.86 * s.h
    if round_form or st.chance("oval", 0.3):
        yield _can(s, taper, body, 0.012)
        if form == "open":
            yield span((-s.x, body - 0.03, -s.z), (s.x, body, s.z), "trim", kind="torus", ratio=0.12, solid=False)
            yield lathe(
                [(0, 0.3 * body), (0.8 * s.x, 0.3 * body), (0.7 * s.x, 0.45 * body), (0, 0.4 * body)],
                slot="pale",
                solid=False,
                stretch=(1.0, s.z / s.x),
            )
        else:
            crown = [(0, body), (s.x, body), (0.98 * s.x, body + 0.3 * (s.h - body)), (0.6 * s.x, s.h), (0, s.h)]
            yield lathe(crown, slot="second", stretch=(1.0, s.z / s.x))
    else:
        yield from _tub(s, taper, body, 0.012, "main")
        if form != "open":
            yield span((-s.x, body, -s.z), (s.x, s.h, s.z), "second", bevel=0.03)
        else:
            for sign in (-1, 1):
                yield span(
                    (-s.x, body - 0.03, sign * (s.z - 0.01) - 0.01), (s.x, body, sign * (s.z - 0.01) + 0.01), "trim", solid=False
                )
                yield span(
                    (sign * (s.x - 0.01) - 0.01, body - 0.03, -s.z), (sign * (s.x - 0.01) + 0.01, body, s.z), "trim", solid=False
                )
    if form == "pedal":
        yield span((-0.05, 0.01, taper * s.z - 0.02), (0.05, 0.03, s.z), "metal", bevel=0.005, solid=False)
    if form == "swing":
        yield span((-0.5 * s.x, body + 0.02, 0.6 * s.z), (0.5 * s.x, s.h - 0.02, 0.97 * s.z), "dark", bevel=0.006, solid=False)


def garbage_bag(s: Subject) -> Iterator[Part]:
    """Yield a tied garbage bag."""
    neck = 0.78 * s.h
    yield lathe(
        [
            (0, 0),
            (0.36 * s.w, 0),
            (0.49 * s.w, 0.14 * s.h),
            (0.5 * s.w, 0.34 * s.h),
            (0.4 * s.w, 0.56 * s.h),
            (0.2 * s.w, 0.7 * s.h),
            (0.06 * s.w, neck),
            (0, neck),
        ],
        stretch=(1.0, s.d / s.w),
        segments=16,
    )
    for i in range(9):
        angle = 40.0 * i + s.style.uniform(f"fold {i}", -14, 14)
        tip = about("y", angle) @ [0.16 * s.w, 0, 0]
        yield bar(
            (0, neck - 0.03, 0),
            (tip[0], s.h - 0.02 - s.style.uniform(f"ear {i}", 0, 0.06), tip[2]),
            0.1 * s.w,
            0.006,
            "main",
            solid=False,
        )
        side = about("y", angle + 20) @ [0.43 * s.w, 0, 0]
        yield tube(
            [
                (side[0] * 0.5, 0.62 * s.h, side[2] * 0.5 * s.d / s.w),
                (side[0], 0.36 * s.h, side[2] * s.d / s.w),
                (side[0] * 0.95, 0.12 * s.h, side[2] * 0.95 * s.d / s.w),
            ],
            0.012,
            "main",
            solid=False,
        )
    yield column(0, 0, neck - 0.012, neck + 0.012, 0.045 * s.w, "accent", solid=False)
    yield column(0, 0, neck, s.h, 0.03 * s.w, "main")


def box(s: Subject) -> Iterator[Part]:
    """Yield a cardboard box, its flaps open or folded in."""
    st = s.style
    wall = 0.006
    open_flaps = st.chance("open", 0.7)
    flap = 0.0
    if open_flaps:
        flap = min(0.16 * s.w, 0.3 * s.h)
    high = s.h - 0.45 * flap
    x, z = s.x - 0.75 * flap, s.z - 0.75 * flap
    yield span((-x, 0, -z), (x, wall, z), "main")
    for sign in (-1, 1):
        low, far = sorted((sign * x, sign * (x - wall)))
        yield span((low, 0, -z), (far, high, z), "main")
        low, far = sorted((sign * z, sign * (z - wall)))
        yield span((-x, 0, low), (x, high, far), "main")
    yield span((-x - 0.0008, 0.35 * high, z - 0.02), (x + 0.0008, 0.62 * high, z + 0.0008), "picture", solid=False)
    if open_flaps:
        rise = 0.45 * flap
        for sign in (-1, 1):
            yield bar(
                (sign * x, high, 0),
                (sign * s.x, high + rise * st.uniform(f"flap {sign}", -0.6, 1.0), 0),
                0.004,
                2 * z,
                "main",
                solid=False,
            )
            up = rise * st.uniform(f"end {sign}", 0.4, 1.0)
            tilt = about("x", -sign * float(np.degrees(np.arctan2(up, s.z - z))))
            middle = (0, high + up / 2, sign * (z + s.z) / 2)
            yield Part("box", middle, (2 * x, 0.004, float(np.hypot(up, s.z - z))), tilt, "main", solid=False)
    else:
        yield span((-x, high - 0.005, -z), (-0.003, high, z), "main")
        yield span((0.003, high - 0.005, -z), (x, high, z), "main")
        yield span((-0.03, high - 0.006, -z), (0.03, high + 0.0005, z), "accent", solid=False)


FORMS = {
    "LaundryHamper": hamper,
    "GarbageCan": garbage_can,
    "GarbageBag": garbage_bag,
    "Box": box,
}
