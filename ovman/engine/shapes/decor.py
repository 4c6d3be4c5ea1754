"""Statues, vases, plants and what stands about for its looks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman.engine.shapes.part import Part, about, bar, column, lathe, rod, span, tube
from ovman.engine.shapes.subject import Subject
from ovman.engine.shapes.tableware import Profile, scaled, vessel

VASES: tuple[Profile, ...] = (
    [(0.5, 0), (0.55, 0.03), (0.98, 0.38), (0.9, 0.58), (0.42, 0.82), (0.4, 0.9), (0.56, 1.0)],
    [(0.62, 0), (0.7, 0.25), (1.0, 0.72), (0.8, 0.9), (0.5, 0.95), (0.55, 1.0)],
    [(0.7, 0), (1.0, 0.2), (0.92, 0.38), (0.3, 0.62), (0.22, 0.85), (0.38, 1.0)],
    [(0.6, 0), (0.66, 0.02), (0.72, 0.5), (0.86, 0.85), (1.0, 1.0)],
    [(0.78, 0), (0.98, 0.12), (1.0, 0.5), (0.96, 0.88), (0.7, 0.97), (0.68, 1.0)],
    [(0.45, 0), (0.5, 0.04), (0.2, 0.12), (0.24, 0.2), (0.95, 0.5), (0.9, 0.7), (0.6, 0.86), (1.0, 1.0)],
    [(0.5, 0), (0.85, 0.16), (0.5, 0.36), (1.0, 0.6), (0.45, 0.84), (0.62, 1.0)],
)


def vase(s: Subject) -> Iterator[Part]:
    st = s.style
    flat: tuple[Profile, ...] = (
        [(0.35, 0), (0.4, 0.1), (0.8, 0.4), (1.0, 1.0)],
        [(0.6, 0), (1.0, 0.45), (0.9, 0.8), (0.97, 1.0)],
    )
    profile = st.choice("profile", VASES if s.h > 0.75 * s.w else flat)
    stretch = (1.0, s.z / s.x)
    yield lathe(vessel(scaled(profile, s.x, s.h), min(0.006, 0.05 * s.w), 0.05 * s.h), slot="main", stretch=stretch, segments=32)
    heights = [y for _, y in profile]
    radii = [r for r, _ in profile]
    for i in range(st.whole("bands", 0, 3)):
        y = st.uniform(f"band {i}", 0.15, 0.9)
        thick = st.uniform(f"thick {i}", 0.015, 0.05)
        low, high = (float(np.interp(y + d, heights, radii)) for d in (-thick, thick))
        ring = [
            (low * 1.004, y - thick),
            (high * 1.004, y + thick),
            (high * 0.96, y + thick),
            (low * 0.96, y - thick),
            (low * 1.004, y - thick),
        ]
        yield lathe(scaled(ring, s.x, s.h), slot="accent" if i % 2 else "second", stretch=stretch, solid=False, segments=32)
    if st.chance("handles", 0.3) and s.h > 0.75 * s.w:
        for sx in (-1, 1):
            r_low, r_high = (float(np.interp(y, heights, radii)) * s.x for y in (0.5, 0.85))
            yield tube(
                [
                    (sx * r_low * 0.97, 0.5 * s.h, 0),
                    (sx * s.x * 0.95, 0.62 * s.h, 0),
                    (sx * s.x * 0.95, 0.78 * s.h, 0),
                    (sx * r_high * 0.97, 0.86 * s.h, 0),
                ],
                0.03 * s.w,
                "main",
                solid=False,
            )


def statue(s: Subject) -> Iterator[Part]:
    """A plinth and one of a few figures, by asset and by how upright it is: bust, standing figure, animal, bird, abstract."""
    st = s.style
    plinth = 0.09 * s.h
    form = st.choice("plinth", ("box", "cylinder"))
    yield span((-s.x, 0, -s.z), (s.x, plinth, s.z), "second", kind=form, bevel=0.05 * plinth)
    slender = s.slenderness
    if slender > 1.5:
        figure = st.choice("figure", (_bust, _standing, _abstract, _bird, _flame))
    else:
        figure = st.choice("figure", (_animal, _bird, _knot, _animal) if slender < 1.1 else (_animal, _bird, _bust))
    yield from figure(s, plinth)


def _bust(s: Subject, low: float) -> Iterator[Part]:
    high = s.h - low
    yield lathe(
        [(0, low), (0.3 * s.w, low), (0.18 * s.w, low + 0.12 * high), (0, low + 0.14 * high)],
        slot="main",
        solid=False,
        stretch=(1.0, s.d / s.w),
    )
    yield Part("cushion", (0, low + 0.3 * high, 0), (s.w * 0.96, 0.34 * high, 0.8 * s.d), slot="main", ratio=0.7)
    yield rod((0, low + 0.38 * high, -0.03 * s.d), (0, low + 0.66 * high, 0.0), 0.15 * min(s.w, s.d), "main", solid=False)
    yield Part("ellipsoid", (0, s.h - 0.22 * high, 0.02 * s.d), (0.46 * s.w, 0.44 * high, 0.6 * s.d), slot="main")
    yield Part("ellipsoid", (0, s.h - 0.25 * high, 0.32 * s.d), (0.08 * s.w, 0.14 * high, 0.14 * s.d), slot="main", solid=False)
    yield Part("ellipsoid", (0, s.h - 0.14 * high, -0.05 * s.d), (0.52 * s.w, 0.28 * high, 0.62 * s.d), slot="main", solid=False)
    for sx in (-1, 1):
        yield Part(
            "ellipsoid", (sx * 0.22 * s.w, s.h - 0.26 * high, 0), (0.06 * s.w, 0.12 * high, 0.12 * s.d), slot="main", solid=False
        )


def _standing(s: Subject, low: float) -> Iterator[Part]:
    high = s.h - low
    raised = s.style.chance("raised arm", 0.5)
    for sx in (-1, 1):
        yield rod(
            (sx * 0.16 * s.w, low, 0.05 * s.d * sx),
            (sx * 0.1 * s.w, low + 0.46 * high, 0),
            0.09 * s.w,
            "main",
            kind="frustum",
            ratio=1.5,
            solid=False,
        )
        yield Part(
            "ellipsoid",
            (sx * 0.17 * s.w, low + 0.02 * high, 0.14 * s.d),
            (0.2 * s.w, 0.05 * high, 0.5 * s.d),
            slot="main",
            solid=False,
        )
        up = raised and sx > 0
        hand = (sx * 0.46 * s.w, low + (0.92 if up else 0.42) * high, 0.2 * s.d)
        elbow = (sx * 0.42 * s.w, low + (0.74 if up else 0.56) * high, 0)
        yield tube([(sx * 0.22 * s.w, low + 0.74 * high, 0), elbow, hand], 0.055 * s.w, "main", solid=False)
    yield Part("cushion", (0, low + 0.6 * high, 0), (0.52 * s.w, 0.36 * high, 0.6 * s.d), slot="main", ratio=0.7, solid=False)
    yield rod((0, low + 0.74 * high, 0), (0, low + 0.86 * high, 0), 0.08 * s.w, "main", solid=False)
    yield Part("ellipsoid", (0, s.h - 0.09 * high, 0.02 * s.d), (0.28 * s.w, 0.18 * high, 0.5 * s.d), slot="main", solid=False)
    yield span((-0.4 * s.w, low, -0.4 * s.d), (0.4 * s.w, s.h, 0.4 * s.d), drawn=False, kind="cylinder")


def _animal(s: Subject, low: float) -> Iterator[Part]:
    """A four-legged animal in profile along the longer side."""
    st = s.style
    along_x = s.along_x
    u, v = (s.x, s.z) if along_x else (s.z, s.x)
    high = s.h - low

    def at(a: float, y: float, b: float = 0.0) -> tuple[float, float, float]:
        return (a, y, b) if along_x else (b, y, a)

    belly = low + 0.36 * high
    neck = st.uniform("neck", 0.1, 0.3)
    for a in (-0.55, 0.5):
        for b in (-0.45, 0.45):
            yield rod(
                at(a * u, low, b * v),
                at(a * u * 0.94, belly + 0.1 * high, b * v * 0.8),
                0.16 * v,
                "main",
                kind="frustum",
                ratio=1.4,
                solid=False,
            )
    yield Part("ellipsoid", at(-0.02 * u, belly + 0.14 * high), at(1.4 * u, 0.36 * high, 1.5 * v), slot="main", solid=False)
    yield span(at(-0.8 * u, low, -0.8 * v), at(0.8 * u, belly + 0.3 * high, 0.8 * v), drawn=False)
    head = at(0.72 * u, s.h - 0.17 * high)
    yield rod(at(0.45 * u, belly + 0.2 * high), head, 0.3 * v, "main", kind="frustum", ratio=0.7, solid=False)
    yield Part("ellipsoid", head, at(0.44 * u, 0.22 * high, 0.9 * v), slot="main")
    yield Part("ellipsoid", at(0.9 * u, s.h - 0.21 * high), at(0.2 * u, 0.13 * high, 0.5 * v), slot="main", solid=False)
    for b in (-0.3, 0.3):
        yield rod(
            at(0.68 * u, s.h - 0.1 * high, b * v),
            at(0.62 * u, s.h, 1.3 * b * v),
            0.13 * v,
            "main",
            kind="frustum",
            ratio=0.2,
            solid=False,
        )
    yield tube(
        [
            at(-0.68 * u, belly + 0.2 * high),
            at(-0.9 * u, belly + (0.2 + neck) * high),
            at(-0.97 * u, belly + (0.1 + 1.5 * neck) * high),
        ],
        0.1 * v,
        "main",
        solid=False,
    )


def _bird(s: Subject, low: float) -> Iterator[Part]:
    high = s.h - low
    along_x = s.along_x
    u, v = (s.x, s.z) if along_x else (s.z, s.x)

    def at(a: float, y: float, b: float = 0.0) -> tuple[float, float, float]:
        return (a, y, b) if along_x else (b, y, a)

    lean = about("z", 28.0) if along_x else about("x", -28.0)
    yield Part("ellipsoid", at(0, low + 0.42 * high), at(1.5 * u, 0.46 * high, 1.7 * v), lean, "main")
    yield Part("ellipsoid", at(0.45 * u, s.h - 0.16 * high), at(0.66 * u, 0.32 * high, 1.1 * v), slot="main")
    yield rod(
        at(0.7 * u, s.h - 0.17 * high),
        at(0.99 * u, s.h - 0.2 * high),
        0.05 * high,
        "accent",
        kind="frustum",
        ratio=0.1,
        solid=False,
    )
    for b in (-1, 1):
        yield Part(
            "ellipsoid",
            at(-0.12 * u, low + 0.45 * high, b * 0.72 * v),
            at(1.1 * u, 0.3 * high, 0.4 * v),
            lean,
            "second",
            solid=False,
        )
        yield rod(at(0.05 * u, low, b * 0.3 * v), at(0.0, low + 0.28 * high, b * 0.3 * v), 0.03 * high, "accent", solid=False)
    yield bar(at(-0.5 * u, low + 0.3 * high), at(-0.98 * u, low + 0.14 * high), 0.5 * v, 0.05 * high, "second", solid=False)


def _abstract(s: Subject, low: float) -> Iterator[Part]:
    """A twisted stack."""
    count = s.style.whole("blocks", 4, 7)
    twist = s.style.uniform("twist", 10, 32)
    step = (s.h - low) / count
    for i in range(count):
        share = 0.66 - 0.34 * abs(2 * (i + 0.5) / count - 1) * s.style.uniform("waist", -0.6, 1.0)
        yield Part(
            "box",
            (0, low + (i + 0.5) * step, 0),
            (share * s.w, step * 1.001, share * s.d),
            about("y", twist * i),
            "main" if i % 2 else "accent",
            bevel=0.08 * step,
        )


def _flame(s: Subject, low: float) -> Iterator[Part]:
    """Two bands that wind around each other."""
    turns = s.style.uniform("turns", 0.8, 1.6)
    for phase in (0.0, np.pi):
        t = np.linspace(0, 1, 17)
        swell = np.sin(np.pi * t) ** 0.7 * 0.36
        angle = phase + 2 * np.pi * turns * t
        path = np.stack(
            [swell * s.w * np.cos(angle), low + (s.h - low - 0.09 * s.w) * t + 0.03 * s.w, swell * s.d * np.sin(angle)], axis=1
        )
        yield tube(path, 0.085 * min(s.w, s.d), "main" if phase else "accent", solid=False)
    yield span((-0.42 * s.w, low, -0.42 * s.d), (0.42 * s.w, s.h, 0.42 * s.d), drawn=False, kind="ellipsoid")


def _knot(s: Subject, low: float) -> Iterator[Part]:
    """A row of rings along the longer side, linked."""
    along_x = s.along_x
    half, deep = (s.x, s.z) if along_x else (s.z, s.x)
    high = s.h - low
    count = max(1, round(2 * half / high * 1.3))
    wide = 2 * half / (1 + 0.72 * (count - 1))
    for i in range(count):
        u = -half + wide / 2 + 0.72 * wide * i
        tilt = (1 if i % 2 else -1) * s.style.uniform("tilt", 8, 26) if count > 1 else 0.0
        size = (wide, 0.5 * deep, high)
        turn = (about("y", tilt) if along_x else about("y", 90.0 + tilt)) @ about("x", 90.0)
        centre = (u, low + high / 2, 0) if along_x else (0, low + high / 2, u)
        yield Part(
            "torus", centre, size, turn, "main" if i % 2 else "accent", solid=False, ratio=s.style.uniform("band", 0.22, 0.4)
        )
    if along_x:
        yield span((-0.9 * half, low, -0.3 * deep), (0.9 * half, low + 0.9 * high, 0.3 * deep), drawn=False)
    else:
        yield span((-0.3 * deep, low, -0.9 * half), (0.3 * deep, low + 0.9 * high, 0.9 * half), drawn=False)


def house_plant(s: Subject) -> Iterator[Part]:
    """A pot with soil and one of several habits: arching blades, a leafy shrub, a stemmed tree, a spiky rosette."""
    st = s.style
    wide = min(s.x, s.z)
    high = st.uniform("pot", 0.26, 0.4) * s.h
    radius = min(st.uniform("pot width", 0.48, 0.72) * wide, 0.6 * high + 0.03)
    taper = st.uniform("taper", 0.66, 0.95)
    if st.chance("square pot", 0.2):
        yield span((-radius, 0, -radius), (radius, high, radius), "main", bevel=0.006)
        yield span((-0.9 * radius, high - 0.01, -0.9 * radius), (0.9 * radius, high + 0.001, 0.9 * radius), "soil", solid=False)
    else:
        lip = st.uniform("lip", 0.0, 0.1)
        outside = [(taper * radius, 0), ((1 - lip) * radius, 0.8 * high), (radius, 0.82 * high), (radius, high)]
        yield lathe(vessel(outside, 0.08 * radius, 0.78 * high), slot="main", segments=28)
        yield column(0, 0, 0.7 * high, 0.9 * high, 0.9 * radius, "soil", solid=False)
        yield column(0, 0, 0, 0.8 * high, taper * radius, drawn=False)
    top = 0.88 * high
    crown = s.h - top
    habit = st.choice("habit", ("blades", "shrub", "shrub", "tree", "rosette", "fern"))
    draw = st.uniform
    if habit in ("blades", "rosette", "fern"):
        count = {"blades": 26, "rosette": 34, "fern": 40}[habit]
        broad = {"blades": 0.1, "rosette": 0.13, "fern": 0.07}[habit] * (wide + 0.1)
        for i in range(count):
            ring = (i * 0.618034) % 1.0
            lean = {"blades": 8 + 38 * ring, "rosette": 15 + 60 * ring, "fern": 20 + 62 * ring}[habit]
            lean = 4.0 + 5.0 * i if i < 4 else lean
            length = crown / max(0.35, np.cos(np.radians(lean))) * (1.0 if i < 2 else draw(f"length {i}", 0.6, 0.98))
            angle = np.radians(137.508 * i)
            reach = 1 / np.hypot(np.sin(angle) / s.x, np.cos(angle) / s.z)
            length = min(length, 0.96 * reach / max(0.12, np.sin(np.radians(lean))))
            curl = length * {"blades": 0.12, "rosette": 0.06, "fern": 0.3}[habit]
            curl = min(curl, 0.35 * reach)
            turn = about("y", 137.508 * i) @ about("x", lean)
            yield Part(
                "leaf",
                (0, top, 0),
                (broad * draw(f"broad {i}", 0.7, 1.2), length, curl),
                turn,
                "leaf" if i % 3 else "leaf_second",
                solid=False,
                segments=5,
            )
        yield column(0, 0, top, top + 0.8 * crown, 0.4 * wide, drawn=False, kind="frustum", ratio=1.5)
        return
    stems = 1 if habit == "tree" else st.whole("stems", 4, 7)
    heart = top + (0.42 if habit == "tree" else 0.2) * crown
    count = st.whole("leaves", 52, 84)
    middle = np.array([0.0, (heart + s.h) / 2, 0.0])
    reach = np.array([0.8 * s.x, 0.42 * (s.h - heart), 0.8 * s.z])
    for i in range(stems):
        tip = about("y", 137.5 * i) @ [0, 0, 0.0 if habit == "tree" else 0.45 * wide]
        yield tube(
            [(0, top - 0.01, 0), (0.4 * tip[0], top + 0.4 * (heart - top), 0.4 * tip[2]), (tip[0], middle[1], tip[2])],
            0.008 + 0.012 * (habit == "tree"),
            "trim",
            solid=False,
        )
    size = st.uniform("leaf", 0.16, 0.3) * (wide + 0.08)
    slim = st.uniform("slim", 0.4, 0.75)
    for i in range(count):
        t = (i + 0.5) / count
        y = 1 - 2 * t
        ring = np.sqrt(1 - y * y)
        angle = 2.399963 * i
        shell = draw(f"shell {i}", 0.55, 1.0)
        direction = np.array([np.cos(angle) * ring, y, np.sin(angle) * ring])
        at = middle + reach * direction * shell * 0.86
        lean = 90.0 - 70.0 * y * 0.6 + draw(f"droop {i}", -18, 25)
        turn = about("y", 90.0 - np.degrees(angle)) @ about("x", lean)
        yield Part(
            "leaf", at, (slim * size, size, 0.22 * size), turn, "leaf" if i % 3 else "leaf_second", solid=False, segments=4
        )
    yield Part("ellipsoid", middle, 1.5 * reach, slot="leaf", drawn=False)


def room_decor(s: Subject) -> Iterator[Part]:
    """A tall floor vase with dry branches, or a slender sculpture."""
    st = s.style
    radius = 0.6 * min(s.x, s.z)
    high = 0.5 * s.h
    profile = st.choice("profile", VASES[:4])
    yield lathe(vessel(scaled(profile, radius, high), 0.01, 0.04), slot="main", segments=32)
    count = st.whole("branches", 9, 15)
    for i in range(count):
        angle = 137.508 * i
        lean = about("y", angle) @ [0, 0, 1.0]
        tip = np.array([lean[0] * s.x, s.h * st.uniform(f"tip {i}", 0.82, 1.0) - 0.02, lean[2] * s.z]) * [
            0.92 * st.uniform(f"out {i}", 0.4, 1.0),
            1,
            0.92 * st.uniform(f"out {i}", 0.4, 1.0),
        ]
        knee = np.array([0.35 * tip[0], 0.5 * (high + tip[1]), 0.35 * tip[2]])
        yield tube([(0, 0.6 * high, 0), (0.1 * tip[0], high, 0.1 * tip[2]), knee, tip], 0.005, "trim", solid=False)
        for j in range(4):
            at = knee + (tip - knee) * (j + 0.6) / 4
            turn = about("y", angle + 90 * j) @ about("x", 50.0)
            yield Part("leaf", at, (0.035, 0.08, 0.02), turn, "leaf", solid=False, segments=3)
    yield span((-0.4 * s.x, high, -0.4 * s.z), (0.4 * s.x, 0.9 * s.h, 0.4 * s.z), drawn=False, kind="cylinder")


def table_top_decor(s: Subject) -> Iterator[Part]:
    """A tray with balls and a pair of candle glasses."""
    yield span((-s.x, 0, -s.z), (s.x, 0.14 * s.h, s.z), "main", bevel=0.006)
    for sign in (-1, 1):
        yield span((sign * (s.x - 0.006) - 0.006, 0, -s.z), (sign * (s.x - 0.006) + 0.006, 0.32 * s.h, s.z), "main", solid=False)
        yield span((-s.x, 0, sign * (s.z - 0.006) - 0.006), (s.x, 0.32 * s.h, sign * (s.z - 0.006) + 0.006), "main", solid=False)
    r = 0.3 * s.h
    for i, (x, z) in enumerate(((-0.5, 0.3), (-0.15, -0.35), (0.12, 0.3))):
        yield Part(
            "ellipsoid",
            (x * s.x, 0.14 * s.h + r, z * s.z),
            (2 * r, 2 * r, 2 * r),
            slot=("second", "accent", "pale")[i],
            solid=False,
        )
    yield lathe(vessel([(0.3 * s.h, 0.14 * s.h), (0.34 * s.h, s.h)], 0.004, 0.2 * s.h), 0.6 * s.x, 0, "glass")


FORMS = {
    "Vase": vase,
    "Statue": statue,
    "HousePlant": house_plant,
    "RoomDecor": room_decor,
    "TableTopDecor": table_top_decor,
}
