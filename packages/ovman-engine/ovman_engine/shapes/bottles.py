"""Bottles, shakers, and cans that pour or spray."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.part import Part, about, bar, column, lathe, rod, span, tube
from ovman_engine.shapes.subject import Subject
from ovman_engine.shapes.vessel import Profile, scaled, turned, vessel


def _bottle(s: Subject, profile: Profile, cap: tuple[float, float, float], label: tuple[float, float] | None) -> Iterator[Part]:
    """Yield a bottle: glass or plastic body, a cap (radius, low, high) in units, and a label band between two heights."""
    body = scaled([(0, 0), *profile, (0, profile[-1][1])], s.x, s.h)
    yield lathe(body, slot="main", stretch=(1.0, s.z / s.x), segments=24)
    r, low, high = cap
    yield span((-r * s.x, low * s.h, -r * s.z), (r * s.x, high * s.h, r * s.z), "accent", kind="cylinder", solid=False)
    if label:
        widest = max(p[0] for p in profile if label[0] - 0.15 <= p[1] <= label[1] + 0.15) * 1.004
        ring = [(widest, label[0]), (widest, label[1]), (widest * 0.95, label[1]), (widest * 0.95, label[0]), (widest, label[0])]
        yield lathe(scaled(ring, s.x, s.h), slot="picture", stretch=(1.0, s.z / s.x), solid=False, segments=24)


def bottle(s: Subject) -> Iterator[Part]:
    """Yield a bottle."""
    yield from _bottle(
        s, [(0.9, 0), (0.995, 0.04), (0.995, 0.55), (0.7, 0.7), (0.34, 0.8), (0.3, 0.93)], (0.36, 0.9, 1.0), (0.14, 0.5)
    )


def wine_bottle(s: Subject) -> Iterator[Part]:
    """Yield a wine bottle."""
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
    """Yield a salt or pepper shaker."""
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


FORMS = {
    "Bottle": bottle,
    "WineBottle": wine_bottle,
    "SoapBottle": soap_bottle,
    "SprayBottle": spray_bottle,
    "PepperShaker": shaker,
    "SaltShaker": shaker,
    "WateringCan": watering_can,
}
