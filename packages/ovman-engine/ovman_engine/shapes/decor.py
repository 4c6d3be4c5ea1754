"""Vases and other ornaments."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.part import Part, lathe, span, tube
from ovman_engine.shapes.subject import Subject
from ovman_engine.shapes.vessel import Profile, scaled, vessel

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
    """Yield a vase."""
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


def table_top_decor(s: Subject) -> Iterator[Part]:
    """Yield a tray with balls and a pair of candle glasses."""
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
    "TableTopDecor": table_top_decor,
}
