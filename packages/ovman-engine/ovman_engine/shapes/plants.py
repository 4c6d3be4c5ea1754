"""Plants in pots, branches in vases."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.decor import VASES
from ovman_engine.shapes.part import Part, about, column, lathe, span, tube
from ovman_engine.shapes.subject import Subject
from ovman_engine.shapes.vessel import scaled, vessel


def house_plant(s: Subject) -> Iterator[Part]:
    """Yield a pot with soil and one of several habits: arching blades, a leafy shrub, a stemmed tree, a spiky rosette."""
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
    """Yield a tall floor vase with dry branches, or a slender sculpture."""
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


FORMS = {
    "HousePlant": house_plant,
    "RoomDecor": room_decor,
}
