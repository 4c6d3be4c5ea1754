"""Fruit, vegetables, bread and eggs."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.part import Part, about, bar, rod, span
from ovman_engine.shapes.subject import Subject
from ovman_engine.shapes.vessel import turned


def apple(s: Subject) -> Iterator[Part]:
    """Yield an apple."""
    top = 0.86
    profile = [(0, 0.07), (0.3, 0.0), (0.62, 0.06), (0.88, 0.28), (1.0, 0.52), (0.92, 0.74), (0.6, top), (0.3, 0.85), (0.0, 0.72)]
    yield turned(s, profile, segments=24)
    yield rod((0, 0.7 * s.h, 0), (0.08 * s.w, s.h - 0.002, 0), 0.025 * s.w, "dark", solid=False)
    if s.style.chance("leaf", 0.5):
        yield Part(
            "leaf", (0.06 * s.w, 0.86 * s.h, 0), (0.16 * s.w, 0.34 * s.w, 0.06 * s.w), about("z", -65.0), "leaf", solid=False
        )


def tomato(s: Subject) -> Iterator[Part]:
    """Yield a tomato."""
    yield turned(
        s, [(0, 0.02), (0.4, 0.0), (0.82, 0.16), (1.0, 0.46), (0.9, 0.76), (0.5, 0.93), (0.2, 0.9), (0, 0.86)], segments=24
    )
    for i in range(5):
        turn = about("y", 72.0 * i) @ about("x", 98.0)
        yield Part("leaf", (0, 0.93 * s.h, 0), (0.1 * s.w, 0.32 * s.w, 0.02), turn, "leaf", solid=False)
    yield rod((0, 0.85 * s.h, 0), (0, s.h, 0), 0.03 * s.w, "leaf", solid=False)


def potato(s: Subject) -> Iterator[Part]:
    """Yield a potato."""
    yield span((-s.x, 0, -s.z), (s.x, s.h, s.z), "main", kind="cushion", ratio=0.85)
    for i in range(5):
        y, side = s.style.uniform(f"eye {i}", 0.3, 0.8), s.style.uniform(f"side {i}", -0.6, 0.6)
        yield Part(
            "ellipsoid",
            (side * s.x * 0.9, y * s.h * 0.92, s.z * (0.6 - 1.2 * (i % 2)) * 0.9),
            (0.1 * s.w, 0.05 * s.h, 0.1 * s.w),
            slot="second",
            solid=False,
        )


def egg(s: Subject) -> Iterator[Part]:
    """Yield an egg."""
    yield turned(
        s, [(0, 0), (0.45, 0.04), (0.8, 0.18), (1.0, 0.42), (0.93, 0.62), (0.7, 0.83), (0.36, 0.96), (0, 1.0)], segments=20
    )


def bread(s: Subject) -> Iterator[Part]:
    """Yield a loaf along z: soft crust, cuts across the top."""
    yield span((-s.x, 0, -s.z), (s.x, 0.96 * s.h, s.z), "main", kind="cushion", ratio=s.style.uniform("soft", 0.35, 0.65))
    count = s.style.whole("cuts", 2, 5)
    for i in range(count):
        z = -0.68 * s.z + 1.36 * s.z * i / (count - 1)
        yield bar(
            (-0.5 * s.x, 0.9 * s.h, z - 0.03 * s.d),
            (0.5 * s.x, 0.9 * s.h, z + 0.03 * s.d),
            0.2 * s.h,
            0.04 * s.d,
            "second",
            kind="ellipsoid",
            solid=False,
        )


def lettuce(s: Subject) -> Iterator[Part]:
    """Yield a head along z: a core wrapped in broad leaves that overlap and curl at the open end."""
    middle = s.h / 2
    yield span((-0.8 * s.x, 0.1 * s.h, -0.96 * s.z), (0.8 * s.x, 0.9 * s.h, 0.9 * s.z), "leaf_second", kind="ellipsoid")
    for ring, count in enumerate((5, 7)):
        for i in range(count):
            turn = about("z", 360.0 * (i + 0.5 * ring) / count)
            out = turn @ [0, 0.17 * s.h + 0.03 * s.h * ring, 0]
            reach = s.d * s.style.uniform(f"reach {ring} {i}", 0.74, 0.92)
            yield Part(
                "ellipsoid",
                (out[0] * s.w / s.h, middle + out[1], (0.02 - 0.04 * ring) * s.d),
                (0.56 * s.w, 0.42 * s.h, reach),
                turn @ about("x", 7.0 + 5.0 * ring),
                "leaf" if (i + ring) % 2 else "leaf_second",
                solid=False,
            )
            tip = turn @ [0, 0.2 * s.h, 0]
            curl = turn @ about("z", 25.0 * (-1) ** i) @ about("x", 62.0)
            yield Part(
                "leaf", (tip[0], middle + tip[1], 0.22 * s.d), (0.4 * s.w, 0.34 * s.d, 0.12 * s.d), curl, "leaf", solid=False
            )
    yield span((-0.14 * s.w, middle - 0.14 * s.h, -s.z), (0.14 * s.w, middle + 0.14 * s.h, -0.8 * s.z), "pale", kind="ellipsoid")


FORMS = {"Apple": apple, "Tomato": tomato, "Potato": potato, "Egg": egg, "Bread": bread, "Lettuce": lettuce}
