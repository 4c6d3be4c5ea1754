"""Shower doors and shower curtains."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.part import Part, about, rod, span
from ovman_engine.shapes.subject import Subject


def shower_door(s: Subject) -> Iterator[Part]:
    """Yield a framed pane along its longer side; where the box is deep, two panes that meet at a corner of the stall."""
    if min(s.w, s.d) < 0.3:
        yield from _pane(s, s.type == "ShowerDoor")
        return
    side = 1 if s.style.chance("corner", 0.5) else -1
    for w, d, x, z in ((s.w, 0.05, 0.0, s.z - 0.025), (0.05, s.d, side * (s.x - 0.025), 0.0)):
        for part in _pane(Subject(s.type, w, s.h, d, s.style), False):
            yield part.but(centre=part.centre + [x, 0, z])


def _pane(s: Subject, grip: bool) -> Iterator[Part]:
    along_x = s.along_x
    half, thick = (s.x, s.z) if along_x else (s.z, s.x)
    bars = 0.035

    def block(u0: float, u1: float, y0: float, y1: float, share: float, slot: str, **fields: object) -> Part:
        v = share * thick
        low, high = ((u0, y0, -v), (u1, y1, v)) if along_x else ((-v, y0, u0), (v, y1, u1))
        return span(low, high, slot, **fields)

    yield block(-half, half, 0, bars, 1.0, "metal", solid=False)
    yield block(-half, half, s.h - bars, s.h, 1.0, "metal", solid=False)
    for sign in (-1, 1):
        near, far = sorted((sign * half, sign * (half - bars)))
        yield block(near, far, 0, s.h, 0.9, "metal", solid=False)
    share = min(1.0, 0.004 / thick)
    yield block(-half + bars, half - bars, bars, s.h - bars, share, "glass", solid=False)
    yield block(-half, half, 0, s.h, min(1.0, 0.03 / thick), "glass", drawn=False)
    if grip:
        u = half - 2.4 * bars
        yield block(u - 0.012, u + 0.012, 0.42 * s.h, 0.6 * s.h, 0.95, "metal", bevel=0.004, solid=False)


PLEAT_M = 0.05
"""Width of a pleat of a shower curtain."""


def shower_curtain(s: Subject) -> Iterator[Part]:
    """Pleats that hang from a rail by rings, along the longer side."""
    along_x = s.along_x
    half, deep = (s.x, s.z) if along_x else (s.z, s.x)
    radius = min(0.012, 0.2 * deep)
    top = s.h - 3.4 * radius
    thick = 0.006

    def at(u: float, y: float, v: float) -> np.ndarray:
        return np.array((u, y, v) if along_x else (v, y, u))

    yield rod(at(-half, s.h - radius, 0), at(half, s.h - radius, 0), radius, "metal", solid=False)
    count = max(5, round(2 * half / PLEAT_M))
    for i in range(count):
        first, last = (-half + 2 * half * k / count for k in (i, i + 1))
        swing = (deep - thick) * (1 if i % 2 else -1)
        start, end = at(first, 0, -swing), at(last, 0, swing)
        way = end - start
        turn = about("y", float(np.degrees(np.arctan2(-way[2], way[0]))))
        size = (float(np.linalg.norm(way)), top, thick)
        yield Part("box", (start + end) / 2 + [0, top / 2, 0], size, turn, "cloth", solid=False)
        ring = about("z", 90.0) if along_x else about("x", 90.0)
        middle = at((first + last) / 2, s.h - 1.7 * radius, 0)
        yield Part("torus", middle, (3.4 * radius, 0.006, 3.4 * radius), ring, "metal", solid=False, ratio=0.3, segments=12)
    reach = at(half, 0, deep)
    yield span((-reach[0], 0, -reach[2]), (reach[0], s.h, reach[2]), drawn=False)


FORMS = {
    "ShowerDoor": shower_door,
    "ShowerGlass": shower_door,
    "ShowerCurtain": shower_curtain,
}
