"""Dishes, pots, bottles, cutlery and food wraps: mostly turned forms. Vessels are hollow."""

from __future__ import annotations

from collections.abc import Iterator

from ovman.engine.shapes.part import Part, about, arc, bar, column, lathe, prism, rod, span, tube
from ovman.engine.shapes.subject import Subject

Profile = list[tuple[float, float]]


def vessel(outside: Profile, wall: float, floor: float) -> Profile:
    """A hollow profile: `outside` [(radius, y)] from the foot up, then down inside at `wall` to a bottom at height `floor`."""
    inside = [(max(r - wall, 1e-3), max(y, floor)) for r, y in reversed(outside) if y > floor]
    foot = inside[-1][0] if inside else outside[-1][0] - wall
    return [(0.0, outside[0][1]), *outside, *inside, (0.9 * foot, floor), (0.0, floor)]


def scaled(profile: Profile, radius: float, height: float) -> Profile:
    return [(r * radius, y * height) for r, y in profile]


def turned(s: Subject, profile: Profile, slot: str = "main", **fields: object) -> Part:
    """A profile in unit radius and height, revolved to fill the whole of `s`."""
    return lathe(scaled(profile, s.x, s.h), slot=slot, stretch=(1.0, s.z / s.x), **fields)


BOWLS: tuple[Profile, ...] = (
    [(0.42, 0), (0.45, 0.08), (0.75, 0.3), (0.93, 0.65), (1.0, 1.0)],
    [(0.5, 0), (0.5, 0.06), (0.9, 0.25), (0.97, 0.6), (1.0, 1.0)],
    [(0.35, 0), (0.32, 0.12), (0.55, 0.3), (0.82, 0.62), (1.0, 1.0)],
    [(0.6, 0), (0.85, 0.2), (0.98, 0.55), (0.94, 0.85), (1.0, 1.0)],
)


def bowl(s: Subject) -> Iterator[Part]:
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
    """A cup whose handle reaches +x."""
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
    """A cooking pot with its grips along the longer side; some have a lid."""
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
    """A frying pan; the handle runs along the longer side."""
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


def _bottle(s: Subject, profile: Profile, cap: tuple[float, float, float], label: tuple[float, float] | None) -> Iterator[Part]:
    """A bottle: glass or plastic body, a cap (radius, low, high) in units, and a label band between two heights."""
    body = scaled([(0, 0), *profile, (0, profile[-1][1])], s.x, s.h)
    yield lathe(body, slot="main", stretch=(1.0, s.z / s.x), segments=24)
    r, low, high = cap
    yield span((-r * s.x, low * s.h, -r * s.z), (r * s.x, high * s.h, r * s.z), "accent", kind="cylinder", solid=False)
    if label:
        widest = max(p[0] for p in profile if label[0] - 0.15 <= p[1] <= label[1] + 0.15) * 1.004
        ring = [(widest, label[0]), (widest, label[1]), (widest * 0.95, label[1]), (widest * 0.95, label[0]), (widest, label[0])]
        yield lathe(scaled(ring, s.x, s.h), slot="picture", stretch=(1.0, s.z / s.x), solid=False, segments=24)


def bottle(s: Subject) -> Iterator[Part]:
    yield from _bottle(
        s, [(0.9, 0), (0.995, 0.04), (0.995, 0.55), (0.7, 0.7), (0.34, 0.8), (0.3, 0.93)], (0.36, 0.9, 1.0), (0.14, 0.5)
    )


def wine_bottle(s: Subject) -> Iterator[Part]:
    yield from _bottle(
        s, [(0.92, 0), (0.995, 0.03), (0.995, 0.58), (0.85, 0.66), (0.42, 0.74), (0.34, 0.96)], (0.38, 0.8, 1.0), (0.14, 0.44)
    )


def soap_bottle(s: Subject) -> Iterator[Part]:
    """Body, collar, pump stem and a spout that looks to +z."""
    st = s.style
    body = st.uniform("body", 0.58, 0.72)
    form = st.choice("form", ("round", "box", "oval"))
    if form == "box":
        yield span((-s.x, 0, -s.z), (s.x, body * s.h, s.z), "main", bevel=0.2 * min(s.x, s.z))
        yield span((-0.8 * s.x, 0.12 * s.h, -s.z - 0.0002), (0.8 * s.x, 0.8 * body * s.h, s.z + 0.0002), "picture", solid=False)
    else:
        shape = (
            [(0.9, 0), (1.0, 0.03), (1.0, 0.75 * body), (0.75, 0.92 * body), (0.4, body)]
            if form == "round"
            else [(0.75, 0), (0.95, 0.1), (1.0, 0.3), (0.7, 0.8 * body), (0.4, body)]
        )
        yield lathe(scaled([(0, 0), *shape, (0, body)], s.x, s.h), slot="main", stretch=(1.0, s.z / s.x))
        band = [(1.004, 0.14), (1.004, 0.42), (0.9, 0.42), (0.9, 0.14), (1.004, 0.14)]
        yield lathe(scaled(band, s.x, s.h), slot="picture", stretch=(1.0, s.z / s.x), solid=False)
    r = 0.34 * min(s.x, s.z)
    yield column(0, 0, body * s.h, (body + 0.07) * s.h, r, "accent", solid=False)
    yield column(0, 0, (body + 0.06) * s.h, 0.93 * s.h, 0.35 * r, "accent")
    yield span((-r * 0.8, 0.93 * s.h, -r * 0.8), (r * 0.8, s.h, r * 0.8), "accent", bevel=0.002)
    yield span((-r * 0.4, 0.94 * s.h, 0), (r * 0.4, 0.985 * s.h, s.z * 0.98), "accent", bevel=0.001, solid=False)


def spray_bottle(s: Subject) -> Iterator[Part]:
    """Body, neck, trigger head that looks along the longer side."""
    along_z = not s.along_x
    u, v = (s.z, s.x) if along_z else (s.x, s.z)

    def block(u0: float, u1: float, y0: float, y1: float, share: float, slot: str, **fields: object) -> Part:
        low, high = (u0, y0, -share * v), (u1, y1, share * v)
        if along_z:
            low, high = (low[2], low[1], low[0]), (high[2], high[1], high[0])
        return span(low, high, slot, **fields)

    yield block(-u, 0.5 * u, 0, 0.6 * s.h, 1.0, "main", kind="cylinder")
    yield block(-0.9 * u, 0.4 * u, 0.1 * s.h, 0.45 * s.h, 1.01, "picture", kind="cylinder", solid=False)
    yield block(-0.7 * u, 0.2 * u, 0.58 * s.h, 0.74 * s.h, 0.6, "main", kind="frustum", ratio=0.5)
    yield block(-0.5 * u, 0.0, 0.72 * s.h, 0.8 * s.h, 0.5, "accent", kind="cylinder", solid=False)
    yield block(-0.75 * u, 0.75 * u, 0.84 * s.h, s.h, 0.5, "accent", bevel=0.003)
    yield block(0.7 * u, u, 0.88 * s.h, 0.97 * s.h, 0.35, "dark", solid=False)
    tip = (0, 0.66 * s.h, 0.62 * u) if along_z else (0.62 * u, 0.66 * s.h, 0)
    root = (0, 0.87 * s.h, 0.3 * u) if along_z else (0.3 * u, 0.87 * s.h, 0)
    yield bar(root, tip, 0.5 * v, 0.5 * v, "accent", solid=False)


def shaker(s: Subject) -> Iterator[Part]:
    st = s.style
    form = st.choice(
        "form",
        (
            [(0.85, 0), (1.0, 0.05), (0.8, 0.7), (0.75, 0.74)],
            [(1.0, 0), (0.95, 0.3), (0.6, 0.55), (0.78, 0.74)],
            [(0.9, 0), (1.0, 0.3), (0.8, 0.72)],
        ),
    )
    yield turned(s, [(0, 0), *form, (0, form[-1][1])])
    r = form[-1][0] + 0.04
    low = form[-1][1]
    yield turned(Subject(s.type, s.w * r, s.h, s.d * r, st), [(0, low), (1.0, low), (1.0, 0.9), (0.6, 1.0), (0, 1.0)], "metal")
    for i in range(5):
        spot = about("y", 72.0 * i) @ [0, 0, 0.28 * s.z]
        yield column(spot[0], spot[2], 0.97 * s.h, s.h + 0.0004, 0.05 * s.x, "dark", solid=False)


def watering_can(s: Subject) -> Iterator[Part]:
    """Spout to +z, handle to -z."""
    radius = min(s.x, 0.36 * s.d)
    z = -0.12 * s.d
    body = 0.68 * s.h
    yield lathe(vessel([(radius, 0), (0.92 * radius, body)], 0.004, 0.01), 0, z, "main", stretch=(s.x / radius, 1.0))
    tip = (0, 0.94 * s.h, s.z - 0.02)
    yield rod((0, 0.16 * s.h, z + 0.9 * radius), tip, 0.09 * s.w, "main", kind="frustum", ratio=0.6)
    yield bar(
        (0, 0.9 * s.h, s.z - 0.035),
        (0, 0.97 * s.h, s.z - 0.002),
        0.26 * s.w,
        slot="metal",
        kind="frustum",
        ratio=1.6,
        solid=False,
    )
    path = [
        (0, 0.2 * s.h, z - 0.9 * radius),
        (0, 0.45 * s.h, -s.z + 0.01),
        (0, 0.8 * s.h, -s.z + 0.015),
        (0, s.h - 0.008, -0.25 * s.d),
        (0, 0.96 * s.h, 0.0),
        (0, body, z + 0.8 * radius),
    ]
    yield tube(path, 0.008, "metal", solid=False)


def _blade(s: Subject, tip_high: float, slot: str = "metal") -> Iterator[Part]:
    """A knife along z: handle at -z, blade to +z, its edge down."""
    split = -s.z + 0.42 * s.d
    thick = 0.16 * s.w
    yield span((-s.x, 0.3 * s.h, -s.z), (s.x, 0.86 * s.h, split), "main", bevel=0.3 * s.w)
    outline = [(-s.z, 0)]
    outline = [(split, 0.0), (s.z - 0.2 * s.d, 0.0), (s.z, tip_high * s.h), (s.z - 0.1 * s.d, s.h), (split, s.h)]
    turned_outline = [(-u, y) for u, y in reversed(outline)]
    blade = prism(turned_outline, -thick, thick, slot)
    turn = about("y", 90.0)
    yield blade.but(centre=turn @ blade.centre, rotation=turn)


def knife(s: Subject) -> Iterator[Part]:
    yield from _blade(s, 0.35)


def butter_knife(s: Subject) -> Iterator[Part]:
    yield from _blade(s, 0.55)


def spoon(s: Subject) -> Iterator[Part]:
    bowl_z = s.z - 0.27 * s.d
    yield span((-s.x, 0, bowl_z), (s.x, 0.55 * s.h, s.z), "metal", kind="ellipsoid")
    yield span(
        (-0.8 * s.x, 0.3 * s.h, bowl_z + 0.03 * s.d),
        (0.8 * s.x, 0.57 * s.h, s.z - 0.03 * s.d),
        "dark",
        kind="ellipsoid",
        solid=False,
    )
    yield bar((0, 0.35 * s.h, bowl_z + 0.02 * s.d), (0, 0.8 * s.h, -0.1 * s.d), 0.14 * s.h, 0.22 * s.w, "metal", solid=False)
    yield bar((0, 0.8 * s.h, -0.1 * s.d), (0, 0.9 * s.h, -s.z + 0.02 * s.d), 0.2 * s.h, 0.3 * s.w, "metal")
    yield span((-0.24 * s.w, 0.74 * s.h, -s.z), (0.24 * s.w, s.h, -s.z + 0.14 * s.d), "metal", kind="ellipsoid", solid=False)


def fork(s: Subject) -> Iterator[Part]:
    root = s.z - 0.22 * s.d
    yield span((-s.x, 0.1 * s.h, root - 0.08 * s.d), (s.x, 0.4 * s.h, root + 0.02 * s.d), "metal", kind="cushion", ratio=0.5)
    for i in range(4):
        x = -0.88 * s.x + 1.76 * s.x * i / 3
        yield bar((x, 0.25 * s.h, root), (x, 0.5 * s.h, s.z - 0.03 * s.d), 0.16 * s.h, 0.24 * s.x, "metal", solid=False)
        yield bar((x, 0.4 * s.h, s.z - 0.08 * s.d), (x, 0.6 * s.h, s.z), 0.14 * s.h, 0.18 * s.x, "metal", solid=False)
    yield bar((0, 0.2 * s.h, root - 0.05 * s.d), (0, 0.85 * s.h, -0.05 * s.d), 0.16 * s.h, 0.26 * s.w, "metal", solid=False)
    yield bar((0, 0.8 * s.h, -0.1 * s.d), (0, 0.6 * s.h, -s.z + 0.02 * s.d), 0.2 * s.h, 0.34 * s.w, "metal")
    yield span((-0.3 * s.w, 0, -s.z), (0.3 * s.w, s.h, -s.z + 0.12 * s.d), "metal", kind="ellipsoid", solid=False)


def spatula(s: Subject) -> Iterator[Part]:
    split = s.z - 0.3 * s.d
    yield span((-s.x, 0, split), (s.x, 0.25 * s.h, s.z), "metal", bevel=0.05 * s.h)
    for i in range(3):
        x = (i - 1) * 0.5 * s.x
        yield span(
            (x - 0.08 * s.x, 0.05 * s.h, split + 0.05 * s.d), (x + 0.08 * s.x, 0.27 * s.h, s.z - 0.05 * s.d), "dark", solid=False
        )
    yield bar((0, 0.15 * s.h, split + 0.01), (0, 0.7 * s.h, 0.05 * s.d), 0.2 * s.h, 0.2 * s.w, "metal", solid=False)
    yield bar((0, 0.7 * s.h, 0.05 * s.d), (0, 0.8 * s.h, -s.z), 0.4 * s.h, 0.36 * s.w, "main", bevel=0.1 * s.h)


def ladle(s: Subject) -> Iterator[Part]:
    radius = min(s.x, 0.18 * s.d)
    profile = vessel([(0.3 * radius, 0), (0.8 * radius, 0.2 * s.h), (radius, 0.55 * s.h)], 0.0025, 0.05 * s.h)
    yield lathe(profile, 0, s.z - radius, "metal", stretch=(s.x / radius, 1.0))
    yield bar((0, 0.5 * s.h, s.z - 1.9 * radius), (0, 0.9 * s.h, -s.z + 0.02), 0.005, 0.18 * s.x + 0.004, "metal")
    yield span(
        (-0.16 * s.w, 0.8 * s.h, -s.z), (0.16 * s.w, s.h, -s.z + 0.28 * s.d), "main", kind="cushion", ratio=0.5, solid=False
    )


def paper_roll(s: Subject) -> Iterator[Part]:
    """A roll on end with a hollow core."""
    core = 0.28 * s.x
    ring = [(core, 0), (s.x, 0), (s.x, s.h), (core, s.h), (core, 0)]
    yield span((-s.x, 0, -s.z), (s.x, s.h, s.z), drawn=False, kind="cylinder")
    yield lathe(ring, slot="main", stretch=(1.0, s.z / s.x), solid=False)
    tube_ring = [(0.8 * core, 0.001), (core, 0.001), (core, s.h - 0.001), (0.8 * core, s.h - 0.001), (0.8 * core, 0.001)]
    yield lathe(tube_ring, slot="second", stretch=(1.0, s.z / s.x), solid=False)


def foil(s: Subject) -> Iterator[Part]:
    """A carton along x with a printed side and a strip of foil."""
    yield span((-s.x, 0, -s.z), (s.x, s.h, 0.94 * s.z), "main", bevel=0.002)
    yield span((-0.9 * s.x, 0.15 * s.h, 0.9 * s.z), (0.9 * s.x, 0.85 * s.h, 0.96 * s.z), "picture", solid=False)
    yield span((-0.95 * s.x, 0.1 * s.h, 0.9 * s.z), (0.95 * s.x, 0.2 * s.h, s.z), "metal", solid=False)


FORMS = {
    "Bowl": bowl,
    "Plate": plate,
    "Cup": cup,
    "Mug": mug,
    "Pot": pot,
    "Pan": pan,
    "Bottle": bottle,
    "WineBottle": wine_bottle,
    "SoapBottle": soap_bottle,
    "SprayBottle": spray_bottle,
    "PepperShaker": shaker,
    "SaltShaker": shaker,
    "WateringCan": watering_can,
    "Knife": knife,
    "ButterKnife": butter_knife,
    "Spoon": spoon,
    "Fork": fork,
    "Spatula": spatula,
    "Ladle": ladle,
    "PaperTowelRoll": paper_roll,
    "ToiletPaper": paper_roll,
    "AluminumFoil": foil,
}
