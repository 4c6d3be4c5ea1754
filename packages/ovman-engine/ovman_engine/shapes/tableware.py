"""Dishes, pots and pans: mostly turned forms. Vessels are hollow."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.part import Part, arc, bar, column, lathe, rod, span, tube
from ovman_engine.shapes.subject import Subject
from ovman_engine.shapes.vessel import Profile, scaled, turned, vessel

BOWLS: tuple[Profile, ...] = (
    [(0.42, 0), (0.45, 0.08), (0.75, 0.3), (0.93, 0.65), (1.0, 1.0)],
    [(0.5, 0), (0.5, 0.06), (0.9, 0.25), (0.97, 0.6), (1.0, 1.0)],
    [(0.35, 0), (0.32, 0.12), (0.55, 0.3), (0.82, 0.62), (1.0, 1.0)],
    [(0.6, 0), (0.85, 0.2), (0.98, 0.55), (0.94, 0.85), (1.0, 1.0)],
)


def bowl(s: Subject) -> Iterator[Part]:
    """Yield a bowl."""
    profile = scaled(s.style.choice("profile", BOWLS), s.x, s.h)
    yield lathe(vessel(profile, min(0.006, 0.06 * s.x + 0.001), 0.12 * s.h), slot="main", stretch=(1.0, s.z / s.x), segments=32)
    if s.style.chance("band", 0.5):
        y = s.style.uniform("band at", 0.72, 0.9)
        r = (
            s.x
            * 1.001
            * (
                profile[-2][0] / s.x + (1 - profile[-2][0] / s.x) * (y - profile[-2][1] / s.h) / (1 - profile[-2][1] / s.h)
                if y > profile[-2][1] / s.h
                else 0.97
            )
        )
        yield span(
            (-r, (y - 0.05) * s.h, -r * s.z / s.x),
            (r, (y + 0.05) * s.h, r * s.z / s.x),
            "accent",
            kind="torus",
            ratio=0.03,
            solid=False,
            segments=32,
        )


def plate(s: Subject) -> Iterator[Part]:
    """Yield a plate."""
    rim = s.style.uniform("rim", 0.6, 0.75)
    profile = [
        (0.0, 0.0),
        (0.55, 0.0),
        (rim, 0.25),
        (0.99, 0.95),
        (1.0, 1.0),
        (0.97, 1.0),
        (rim - 0.03, 0.5),
        (0.5, 0.3),
        (0.0, 0.28),
    ]
    yield turned(s, profile, segments=36, solid=False)
    yield span((-s.x, 0, -s.z), (s.x, s.h * 0.7, s.z), drawn=False, kind="frustum", ratio=1.7)
    well = rim - 0.06
    yield span(
        (-well * s.x, 0.3 * s.h, -well * s.z),
        (well * s.x, 0.42 * s.h, well * s.z),
        "second",
        kind="cylinder",
        solid=False,
        segments=36,
    )
    if s.style.chance("ring", 0.75):
        share = s.style.uniform("ring at", 0.84, 0.96)
        yield span(
            (-share * s.x, 0.5 * s.h, -share * s.z),
            (share * s.x, (0.35 + 0.65 * share) * s.h, share * s.z),
            "accent",
            kind="torus",
            ratio=0.06,
            solid=False,
            segments=36,
        )


def cup(s: Subject) -> Iterator[Part]:
    """Yield a cup."""
    st = s.style
    forms: tuple[Profile, ...] = (
        [(0.72, 0), (0.8, 0.04), (1.0, 1.0)],
        [(0.8, 0), (0.92, 0.08), (0.96, 0.5), (1.0, 1.0)],
        [(0.62, 0), (0.66, 0.03), (0.16, 0.1), (0.13, 0.38), (0.7, 0.5), (1.0, 0.72), (0.9, 1.0)],
        [(0.7, 0), (0.95, 0.2), (0.85, 0.6), (1.0, 1.0)],
    )
    form = st.choice("form", forms)
    floor = 0.5 if len(form) > 5 else 0.06
    if len(form) > 5:
        stem = scaled([(0.0, 0.0), *form[:4], (0.3, 0.44), (0.0, 0.46)], s.x, s.h)
        yield lathe(stem, slot="main", stretch=(1.0, s.z / s.x))
        profile = scaled([(0.3, 0.42), *form[4:]], s.x, s.h)
    else:
        profile = scaled(form, s.x, s.h)
    yield lathe(vessel(profile, min(0.004, 0.1 * s.x), floor * s.h), slot="main", stretch=(1.0, s.z / s.x))
    if st.chance("drink", 0.4):
        r = 0.8 * s.x * (form[-2][0] if len(form) < 5 else 0.7)
        yield column(0, 0, (floor + 0.02) * s.h, 0.7 * s.h, r, "accent", solid=False)


def mug(s: Subject) -> Iterator[Part]:
    """Yield a cup whose handle reaches +x."""
    st = s.style
    radius = min(s.z, 0.4 * s.w)
    x = -s.x + radius
    form = st.choice("form", ([(1.0, 0), (1.0, 1.0)], [(0.8, 0), (0.92, 0.1), (1.0, 1.0)], [(0.85, 0), (1.0, 0.3), (0.94, 1.0)]))
    yield lathe(
        vessel(scaled(form, radius, s.h), min(0.005, 0.12 * radius), 0.07 * s.h), x, 0, "main", stretch=(1.0, s.z / radius)
    )
    loop = arc((x + 0.95 * radius, 0.5 * s.h, 0), 1.0, -90, 90, "xy", 9)
    loop[:, 0] = x + 0.93 * radius + (loop[:, 0] - x - 0.95 * radius) * (s.x - x - 0.93 * radius - 0.006)
    loop[:, 1] = 0.5 * s.h + (loop[:, 1] - 0.5 * s.h) * st.uniform("loop", 0.28, 0.36) * s.h
    yield tube(loop, 0.006, "main", solid=False)
    if st.chance("print", 0.6):
        yield lathe(
            [
                (radius * 1.006, 0.25 * s.h),
                (radius * 1.006, 0.8 * s.h),
                (radius * 0.97, 0.8 * s.h),
                (radius * 0.97, 0.25 * s.h),
                (radius * 1.006, 0.25 * s.h),
            ],
            x,
            0,
            "picture",
            stretch=(1.0, s.z / radius),
            solid=False,
        )


def pot(s: Subject) -> Iterator[Part]:
    """Yield a cooking pot with its grips along the longer side; some have a lid."""
    st = s.style
    along_z = not s.along_x
    radius = min(s.x, s.z)
    long_handle = s.elongation > 1.5
    half = max(s.x, s.z)
    offset = half - radius if long_handle else 0.0
    body = s.h * (0.78 if st.chance("lid", 0.4) else 0.96)
    outer = 0.94 * radius

    def at(u: float, y: float, v: float = 0.0) -> tuple[float, float, float]:
        return (v, y, u) if along_z else (u, y, v)

    cx, _, cz = at(-offset, 0)
    yield lathe(vessel([(0.92 * outer, 0), (outer, 0.06 * body), (outer, body)], 0.004, 0.05 * body), cx, cz, "main", segments=30)
    if body < 0.9 * s.h:
        yield lathe(
            [
                (0, body),
                (outer * 1.03, body),
                (outer, body + 0.02 * s.h),
                (0.4 * outer, body + 0.09 * s.h),
                (0, body + 0.1 * s.h),
            ],
            cx,
            cz,
            "second",
            solid=False,
        )
        yield column(cx, cz, body + 0.08 * s.h, s.h, 0.014, "dark", solid=False)
    if long_handle:
        yield bar(at(-offset + 0.95 * outer, 0.8 * body), at(half, 0.86 * body), 0.022, 0.014, "dark", bevel=0.004)
        yield bar(at(-offset - 0.9 * outer, 0.85 * body), at(-half, 0.85 * body), 0.03, 0.012, "dark", solid=False)
        for sv in (-1, 1):
            yield Part("ellipsoid", at(-offset, body, sv * (radius - 0.006)), (0.012, 0.006, 0.012), slot="main", solid=False)
    else:
        for su in (-1, 1):
            bow = arc((0, 0, 0), 1.0, -75, 75, "xy", 7)
            points = [
                at(su * (0.96 * outer + p[0] * (half - 0.96 * outer - 0.006)), 0.8 * body, p[1] * 0.3 * radius) for p in bow
            ]
            yield tube(points, 0.006, "dark", solid=False)
        for sv in (-1, 1):
            yield Part("ellipsoid", at(0, 0.93 * body, sv * (radius - 0.006)), (0.012, 0.01, 0.012), slot="main", solid=False)
    yield column(
        cx, cz, 0.95 * body, 0.97 * body if body < 0.9 * s.h else s.h, radius, "metal", kind="torus", ratio=0.05, solid=False
    )


def pan(s: Subject) -> Iterator[Part]:
    """Yield a frying pan; the handle runs along the longer side."""
    along_z = not s.along_x
    radius = min(s.x, s.z)
    half = max(s.x, s.z)
    offset = -(half - radius)

    def at(u: float, y: float, v: float = 0.0) -> tuple[float, float, float]:
        return (v, y, u) if along_z else (u, y, v)

    cx, _, cz = at(offset, 0)
    high = s.h if half < 1.15 * radius else 0.72 * s.h
    yield lathe(
        vessel([(0.78 * radius, 0), (0.84 * radius, 0.08 * high), (radius, high)], 0.004, 0.1 * high), cx, cz, "main", segments=32
    )
    yield column(cx, cz, 0.08 * high, 0.13 * high, 0.76 * radius, "dark", solid=False, segments=32)
    if half > 1.15 * radius:
        yield rod(at(offset + 0.94 * radius, 0.75 * high), at(half - 0.01, s.h - 0.008), 0.009, "dark", kind="capsule")
        yield rod(at(offset + 0.9 * radius, 0.7 * high), at(offset + 1.15 * radius, 0.8 * high), 0.012, "metal", solid=False)


FORMS = {
    "Bowl": bowl,
    "Plate": plate,
    "Cup": cup,
    "Mug": mug,
    "Pot": pot,
    "Pan": pan,
}
