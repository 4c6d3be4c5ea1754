"""Plungers, brushes, soap and sponges."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.part import Part, column, lathe, span
from ovman_engine.shapes.subject import Subject


def plunger(s: Subject) -> Iterator[Part]:
    """Yield a plunger."""
    cup = 0.22 * s.h
    yield lathe(
        [
            (0, 0.35 * cup),
            (0.8 * s.x, 0),
            (s.x, 0),
            (0.95 * s.x, 0.35 * cup),
            (0.6 * s.x, 0.75 * cup),
            (0.22 * s.x, cup),
            (0, cup),
        ],
        slot="rubber",
        stretch=(1.0, s.z / s.x),
    )
    yield column(0, 0, 0.9 * cup, s.h - 0.02, 0.012, "main")
    yield Part("ellipsoid", (0, s.h - 0.018, 0), (0.034, 0.036, 0.034), slot="main", solid=False)


def scrub_brush(s: Subject) -> Iterator[Part]:
    """Yield a toilet brush in its holder."""
    holder = 0.34 * s.h
    yield lathe(
        [
            (0, 0),
            (0.9 * s.x, 0),
            (s.x, 0.1 * holder),
            (0.82 * s.x, holder),
            (0.74 * s.x, holder),
            (0.8 * s.x, 0.1 * holder),
            (0, 0.08 * holder),
        ],
        slot="main",
        stretch=(1.0, s.z / s.x),
    )
    yield column(0, 0, 0.3 * holder, 1.08 * holder, 0.55 * min(s.x, s.z), "pale", kind="ellipsoid", solid=False)
    yield column(0, 0, 0.8 * holder, 0.97 * s.h, 0.011, "metal")
    yield column(0, 0, 0.82 * s.h, s.h, 0.017, "second", kind="capsule", solid=False)


def soap_bar(s: Subject) -> Iterator[Part]:
    """Yield a bar of soap."""
    yield span((-s.x, 0, -s.z), (s.x, s.h, s.z), "main", kind="cushion", ratio=0.4)
    yield span(
        (-0.6 * s.x, 0.9 * s.h, -0.6 * s.z), (0.6 * s.x, 0.995 * s.h, 0.6 * s.z), "second", kind="cushion", ratio=0.4, solid=False
    )


def sponge(s: Subject) -> Iterator[Part]:
    """Yield a sponge."""
    yield span((-s.x, 0, -s.z), (s.x, 0.74 * s.h, s.z), "main", bevel=0.14 * s.h)
    yield span((-s.x, 0.7 * s.h, -s.z), (s.x, s.h, s.z), "second", bevel=0.08 * s.h)


FORMS = {
    "Plunger": plunger,
    "ScrubBrush": scrub_brush,
    "SoapBar": soap_bar,
    "DishSponge": sponge,
}
