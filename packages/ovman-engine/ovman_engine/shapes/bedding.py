"""Soft objects: pillows, cloths, towels, a bear."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.part import Part, about, span
from ovman_engine.shapes.subject import Subject


def pillow(s: Subject) -> Iterator[Part]:
    """Yield a pillow."""
    yield span(
        (-s.x, 0, -s.z),
        (s.x, s.h, s.z),
        "cloth",
        kind="cushion",
        ratio=s.style.uniform("square", 0.28, 0.45),
        crown=s.style.uniform("puff", 0.85, 1.25),
        segments=32,
    )
    if s.style.chance("piping", 0.4):
        yield span(
            (-s.x * 0.97, 0.47 * s.h, -s.z * 0.97),
            (s.x * 0.97, 0.53 * s.h, s.z * 0.97),
            "accent",
            kind="cushion",
            ratio=0.4,
            solid=False,
            segments=28,
        )


def cloth(s: Subject) -> Iterator[Part]:
    """Yield a folded cloth: layers of slightly different reach."""
    layers = 3
    step = s.h / layers
    for i in range(layers):
        inset = 0.02 * s.w * s.style.fraction(f"layer {i}") if i else 0.0
        yield span(
            (-s.x + inset, i * step, -s.z + inset),
            (s.x - 0.5 * inset, (i + 1) * step, s.z - 0.5 * inset),
            "cloth",
            bevel=0.3 * step,
        )
    yield span(
        (-s.x * 0.72, 0.1 * s.h, -s.z * 0.985), (-s.x * 0.58, s.h + 0.0004, s.z * 0.985), "accent", solid=False, bevel=0.2 * step
    )


def towel(s: Subject) -> Iterator[Part]:
    """Yield a towel over a rail: a short flap behind a long one in front, hem stripes across."""
    fold = min(0.5 * s.d, 0.012)
    front = s.z - fold
    yield span((-s.x, s.h - 1.6 * fold, -s.z), (s.x, s.h, s.z), "cloth", kind="cushion", ratio=0.25, solid=False)
    yield span((-s.x, 0, front), (s.x, s.h - fold, s.z), "cloth", bevel=0.003)
    yield span(
        (-s.x * 0.99, s.style.uniform("back", 0.05, 0.3) * s.h, -s.z), (s.x * 0.99, s.h - fold, -s.z + fold), "cloth", bevel=0.003
    )
    for i in range(s.style.whole("stripes", 1, 3)):
        y = 0.09 * s.h + 0.05 * s.h * i
        yield span((-s.x, y, front - 0.0004), (s.x, y + 0.022 * s.h, s.z + 0.0004), "accent", solid=False)
    count = 5
    for i in range(count):
        x = -s.x + s.w * (i + 0.5) / count
        yield span(
            (x - 0.4 * s.w / count, 0.01, front + 0.25 * fold),
            (x + 0.4 * s.w / count, s.h - 1.5 * fold, s.z + 0.0003),
            "cloth",
            kind="cushion",
            ratio=0.4,
            solid=False,
        )


def teddy(s: Subject) -> Iterator[Part]:
    """Yield a sitting bear, facing +z."""
    head = 0.46 * s.h
    yield span((-0.3 * s.w, 0.0, -s.z), (0.3 * s.w, 0.62 * s.h, 0.2 * s.d), "cloth", kind="ellipsoid")
    yield span((-0.29 * s.w, s.h - head, -0.42 * s.d), (0.29 * s.w, s.h - 0.04 * s.h, 0.32 * s.d), "cloth", kind="ellipsoid")
    yield Part(
        "ellipsoid", (0, s.h - 0.6 * head, 0.3 * s.d), (0.24 * s.w, 0.16 * s.h, 0.2 * s.d), slot="cloth_second", solid=False
    )
    yield Part("ellipsoid", (0, s.h - 0.53 * head, 0.4 * s.d), (0.08 * s.w, 0.05 * s.h, 0.05 * s.d), slot="dark", solid=False)
    yield Part("ellipsoid", (0, 0.28 * s.h, 0.14 * s.d), (0.36 * s.w, 0.4 * s.h, 0.16 * s.d), slot="cloth_second", solid=False)
    for sx in (-1, 1):
        yield Part(
            "ellipsoid",
            (sx * 0.22 * s.w, s.h - 0.08 * s.h, -0.04 * s.d),
            (0.18 * s.w, 0.16 * s.h, 0.1 * s.d),
            slot="cloth",
            solid=False,
        )
        yield Part(
            "ellipsoid",
            (sx * 0.1 * s.w, s.h - 0.4 * head, 0.3 * s.d),
            (0.045 * s.w, 0.045 * s.h, 0.03 * s.d),
            slot="dark",
            solid=False,
        )
        yield Part(
            "ellipsoid",
            (sx * 0.37 * s.w, 0.4 * s.h, 0.1 * s.d),
            (0.2 * s.w, 0.42 * s.h, 0.26 * s.d),
            about("z", sx * 32.0),
            "cloth",
            solid=False,
        )
        yield Part(
            "ellipsoid",
            (sx * 0.3 * s.w, 0.11 * s.h, 0.24 * s.d),
            (0.26 * s.w, 0.22 * s.h, 0.52 * s.d),
            about("y", sx * 18.0),
            "cloth",
        )
        yield Part(
            "ellipsoid",
            (sx * 0.36 * s.w, 0.13 * s.h, 0.47 * s.d),
            (0.18 * s.w, 0.18 * s.h, 0.04 * s.d),
            slot="cloth_second",
            solid=False,
        )


FORMS = {"Pillow": pillow, "Cloth": cloth, "Towel": towel, "HandTowel": towel, "TeddyBear": teddy}
