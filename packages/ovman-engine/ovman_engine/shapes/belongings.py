"""Pens, cards, keys, boots and sports things."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.part import Part, about, lathe, rod, span, tube
from ovman_engine.shapes.subject import Subject


def stick(s: Subject) -> Iterator[Part]:
    """Yield a pen or pencil along its longest side."""
    sides = 6 if s.type == "Pencil" else 12
    half = max(s.x, s.z, s.h / 2)
    radius = min(s.w, s.d, s.h) / 2
    axis = int(np.argmax([s.w, s.h, s.d]))

    def at(u: float) -> np.ndarray:
        point = np.array([0.0, s.h / 2, 0.0])
        point[axis] += u
        return point

    tip = 2.4 * radius
    yield rod(at(-half + 0.02 * half), at(half - tip), radius, "main", segments=sides)
    yield rod(
        at(half - tip),
        at(half),
        radius,
        "pale" if sides == 6 else "metal",
        kind="frustum",
        ratio=0.16,
        solid=False,
        segments=sides,
    )
    if sides == 6:
        yield rod(at(-half), at(-half + 1.8 * radius), 0.96 * radius, "accent", solid=False)
        yield rod(at(-half + 1.6 * radius), at(-half + 3.4 * radius), 1.0 * radius, "metal", solid=False)
    else:
        yield rod(at(-half), at(-half + 0.62 * half), 1.0 * radius, "accent", solid=False)
        clip = at(-half + 0.3 * half)
        clip[(axis + 1) % 3] += 0.8 * radius
        size = np.full(3, 0.4 * radius)
        size[axis] = 0.5 * half
        yield Part("box", clip, size, slot="metal", solid=False)


def credit_card(s: Subject) -> Iterator[Part]:
    """Yield a credit card."""
    yield span((-s.x, 0, -s.z), (s.x, 0.9 * s.h, s.z), "main", bevel=0.3 * s.h)
    yield span((-0.72 * s.x, 0.5 * s.h, -0.2 * s.z), (-0.45 * s.x, s.h, 0.2 * s.z), "metal", solid=False)
    yield span((-0.99 * s.x, 0.5 * s.h, 0.4 * s.z), (0.99 * s.x, 0.95 * s.h, 0.75 * s.z), "dark", solid=False)
    yield span((-0.2 * s.x, 0.5 * s.h, -0.7 * s.z), (0.85 * s.x, 0.96 * s.h, -0.45 * s.z), "picture", solid=False)


def key_chain(s: Subject) -> Iterator[Part]:
    """Yield a ring, a fob and keys that fan out along x."""
    ring = min(0.8 * s.z, 0.24 * s.w)
    x = -s.x + ring
    yield Part("torus", (x, 0.5 * s.h, 0), (2 * ring, 0.5 * s.h, 2 * ring), slot="metal", ratio=0.18)
    count = s.style.whole("keys", 2, 4)
    for i in range(count):
        spread = (i / (count - 1) - 0.5) * 1.3
        tip = np.array([s.x - 0.01 * abs(spread), 0.5 * s.h, spread * s.z])
        root = np.array([x + 1.1 * ring, 0.5 * s.h, 0.3 * spread * s.z])
        turn = about("y", float(np.degrees(np.arctan2(-(tip - root)[2], (tip - root)[0]))))
        length = float(np.linalg.norm(tip - root))
        along = (tip - root) / length
        aside = np.array([-along[2], 0.0, along[0]])
        shaft = root + 0.3 * (tip - root)
        slot = "metal" if i % 2 == 0 else "accent"
        yield Part("box", (shaft + tip) / 2, (0.7 * length, 0.34 * s.h, 0.1 * s.z), turn, slot, solid=i == 0)
        bow = (0.46 * length, 0.4 * s.h, 0.5 * s.z)
        yield Part("torus", root + 0.16 * (tip - root), bow, turn, slot, ratio=0.34, solid=False, segments=12)
        for share in (0.72, 0.84, 0.94):
            tooth = root + share * (tip - root) + 0.09 * s.z * aside
            yield Part("box", tooth, (0.07 * length, 0.3 * s.h, 0.14 * s.z), turn, slot, solid=False)
    yield span((-s.x + 0.1 * s.w, 0, -0.35 * s.z), (-s.x + 0.55 * s.w, s.h, 0.3 * s.z), "cloth", bevel=0.3 * s.h)


def boots(s: Subject) -> Iterator[Part]:
    """Yield a pair side by side, toes to +z."""
    wide = 0.46 * s.w
    for sx in (-1, 1):
        x = sx * (s.x - wide / 2)
        leg = 0.42 * s.d
        z = -s.z + leg
        yield span((x - wide / 2, 0.03 * s.h, -s.z + 0.02), (x + wide / 2, 0.22 * s.h, s.z), "main", kind="cushion", ratio=0.5)
        yield span(
            (x - wide * 0.46, 0, -s.z + 0.02), (x + wide * 0.46, 0.06 * s.h, s.z - 0.005), "rubber", bevel=0.012, solid=False
        )
        shaft = [
            (0, 0.1 * s.h),
            (0.9 * wide / 2, 0.12 * s.h),
            (0.8 * wide / 2, 0.4 * s.h),
            (wide / 2, s.h),
            (0.88 * wide / 2, s.h),
            (0.7 * wide / 2, 0.4 * s.h),
            (0, 0.3 * s.h),
        ]
        yield lathe(shaft, x, z - 0.02, "main", stretch=(1.0, 2 * leg / wide * 0.95), solid=False)
        yield span((x - 0.45 * wide, 0, -s.z + 0.02), (x + 0.45 * wide, s.h, -s.z + 1.9 * leg), drawn=False)
        yield span(
            (x - wide / 2, 0.9 * s.h, z - leg - 0.0),
            (x + wide / 2, 0.99 * s.h, z + 0.9 * leg),
            "accent",
            kind="torus",
            ratio=0.16,
            solid=False,
        )
        yield span((x - 0.01, 0.93 * s.h, -s.z), (x + 0.01, 0.99 * s.h, -s.z + 0.05), "accent", solid=False)


def baseball_bat(s: Subject) -> Iterator[Part]:
    """Yield a baseball bat."""
    profile = [
        (0, 0),
        (0.5, 0.0),
        (0.5, 0.02),
        (0.3, 0.035),
        (0.32, 0.25),
        (0.6, 0.5),
        (0.98, 0.72),
        (1.0, 0.9),
        (0.85, 0.98),
        (0, 1.0),
    ]
    yield lathe([(r * s.x, y * s.h) for r, y in profile], slot="main", stretch=(1.0, s.z / s.x))
    yield span(
        (-0.34 * s.x, 0.05 * s.h, -0.34 * s.z), (0.34 * s.x, 0.24 * s.h, 0.34 * s.z), "cloth", kind="cylinder", solid=False
    )
    yield span(
        (-1.004 * s.x, 0.78 * s.h, -1.004 * s.z),
        (1.004 * s.x, 0.82 * s.h, 1.004 * s.z),
        "accent",
        kind="torus",
        ratio=0.1,
        solid=False,
    )


def basketball(s: Subject) -> Iterator[Part]:
    """Yield a basketball."""
    yield span(
        (-0.996 * s.x, 0.002 * s.h, -0.996 * s.z), (0.996 * s.x, 0.998 * s.h, 0.996 * s.z), "main", kind="ellipsoid", segments=32
    )
    for turn in (about("x", 0.0), about("x", 90.0), about("z", 90.0)):
        yield Part("torus", (0, s.h / 2, 0), (s.w, 0.022 * s.w, s.w), turn, "dark", solid=False, ratio=0.03, segments=32)
    for z in (-0.24, 0.24):
        r = np.sqrt(0.25 - z * z) * 1.004
        yield Part(
            "torus",
            (0, s.h / 2, z * s.d),
            (2 * r * s.w, 0.02 * s.w, 2 * r * s.w),
            about("x", 90.0),
            "dark",
            solid=False,
            ratio=0.03,
            segments=32,
        )


def dumbbell(s: Subject) -> Iterator[Part]:
    """Along its longer side: two heads of stacked plates and a grip."""
    along_z = not s.along_x
    half = s.z if along_z else s.x
    radius = min(s.x if along_z else s.z, s.h / 2)

    def at(u: float) -> tuple[float, float, float]:
        return (0, s.h / 2, u) if along_z else (u, s.h / 2, 0)

    yield rod(at(-half * 0.9), at(half * 0.9), 0.24 * radius, "metal")
    for sign in (-1, 1):
        yield rod(
            at(sign * half * 0.5), at(sign * half), 0.86 * radius, "main", segments=6 if s.style.chance("hexagon", 0.5) else 20
        )
        yield rod(at(sign * half * 0.56), at(sign * half * 0.86), radius, "rubber", segments=20)


def tennis_racket(s: Subject) -> Iterator[Part]:
    """Along y: grip below, strung head above."""
    head = 0.52 * s.h
    middle = s.h - head / 2
    yield Part(
        "torus", (0, middle, 0), (s.w, min(s.d, 0.024), head), about("x", 90.0), "main", solid=False, ratio=0.12, segments=32
    )
    for i in range(1, 10):
        t = 2 * i / 10 - 1
        half = np.sqrt(1 - t * t)
        yield span(
            (t * 0.47 * s.w - 0.0008, middle - 0.46 * head * half, -0.0008),
            (t * 0.47 * s.w + 0.0008, middle + 0.46 * head * half, 0.0008),
            "pale",
            solid=False,
        )
        yield span(
            (-0.47 * s.w * half, middle + t * 0.46 * head - 0.0008, -0.0008),
            (0.47 * s.w * half, middle + t * 0.46 * head + 0.0008, 0.0008),
            "pale",
            solid=False,
        )
    for sx in (-1, 1):
        yield tube(
            [(sx * 0.02, 0.38 * s.h, 0), (sx * 0.16 * s.w, s.h - head, 0), (sx * 0.3 * s.w, s.h - 0.9 * head, 0)],
            0.009,
            "main",
            solid=False,
        )
    yield rod((0, 0.26 * s.h, 0), (0, 0.4 * s.h, 0), 0.014, "main", solid=False)
    yield span((-0.017, 0, -s.z), (0.017, 0.3 * s.h, s.z), "cloth", kind="cylinder", segments=8)
    yield span((-0.45 * s.w, s.h - head, -0.3 * s.d), (0.45 * s.w, s.h, 0.3 * s.d), drawn=False)


FORMS = {
    "Pen": stick,
    "Pencil": stick,
    "CreditCard": credit_card,
    "KeyChain": key_chain,
    "Boots": boots,
    "BaseballBat": baseball_bat,
    "BasketBall": basketball,
    "Dumbbell": dumbbell,
    "TennisRacket": tennis_racket,
}
