"""Knives, spoons, forks and other kitchen tools, along z."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.part import Part, about, bar, lathe, prism, span
from ovman_engine.shapes.subject import Subject
from ovman_engine.shapes.vessel import vessel


def _blade(s: Subject, tip_high: float, slot: str = "metal") -> Iterator[Part]:
    """Yield a knife along z: handle at -z, blade to +z, its edge down."""
    split = -s.z + 0.42 * s.d
    thick = 0.16 * s.w
    yield span((-s.x, 0.3 * s.h, -s.z), (s.x, 0.86 * s.h, split), "main", bevel=0.3 * s.w)
    outline = [(split, 0.0), (s.z - 0.2 * s.d, 0.0), (s.z, tip_high * s.h), (s.z - 0.1 * s.d, s.h), (split, s.h)]
    turned_outline = [(-u, y) for u, y in reversed(outline)]
    blade = prism(turned_outline, -thick, thick, slot)
    turn = about("y", 90.0)
    yield blade.but(centre=turn @ blade.centre, rotation=turn)


def knife(s: Subject) -> Iterator[Part]:
    """Yield a kitchen knife."""
    yield from _blade(s, 0.35)


def butter_knife(s: Subject) -> Iterator[Part]:
    """Yield a butter knife."""
    yield from _blade(s, 0.55)


def spoon(s: Subject) -> Iterator[Part]:
    """Yield a spoon, its bowl to +z."""
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
    """Yield a fork, its tines to +z."""
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
    """Yield a spatula."""
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
    """Yield a ladle."""
    radius = min(s.x, 0.18 * s.d)
    profile = vessel([(0.3 * radius, 0), (0.8 * radius, 0.2 * s.h), (radius, 0.55 * s.h)], 0.0025, 0.05 * s.h)
    yield lathe(profile, 0, s.z - radius, "metal", stretch=(s.x / radius, 1.0))
    yield bar((0, 0.5 * s.h, s.z - 1.9 * radius), (0, 0.9 * s.h, -s.z + 0.02), 0.005, 0.18 * s.x + 0.004, "metal")
    yield span(
        (-0.16 * s.w, 0.8 * s.h, -s.z), (0.16 * s.w, s.h, -s.z + 0.28 * s.d), "main", kind="cushion", ratio=0.5, solid=False
    )


FORMS = {
    "Knife": knife,
    "ButterKnife": butter_knife,
    "Spoon": spoon,
    "Fork": fork,
    "Spatula": spatula,
    "Ladle": ladle,
}
