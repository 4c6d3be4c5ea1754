"""Dressers, shelves, cabinets, drawers and safes. Front at +z."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.fronts import HANDLE_M, PANEL_M, closed_block, doors, drawers, pull
from ovman_engine.shapes.part import Part, about, bar, span
from ovman_engine.shapes.seating import legs
from ovman_engine.shapes.subject import Subject


def dresser(s: Subject) -> Iterator[Part]:
    """Yield a dresser."""
    st = s.style
    foot = st.uniform("foot", 0.04, 0.15)
    top = st.uniform("top", 0.02, 0.035)
    face = s.z - HANDLE_M
    yield span((-s.x, s.h - top, -s.z), (s.x, s.h, s.z), "main", bevel=0.006)
    if st.chance("plinth", 0.4):
        yield span((-s.x + 0.02, 0, -s.z), (s.x - 0.02, foot, face - 0.03), "trim")
    else:
        yield from legs(Subject(s.type, s.w, s.h, s.d - HANDLE_M, st), foot + 0.01, 0.01, 0.045, 0.0, "trim", solid=False)
    if s.inserts:
        inner = Subject(s.type, s.w, s.h, s.d, st, s.inserts)
        for sx in (-1, 1):
            low, high = sorted((sx * s.x, sx * (s.x - 0.02)))
            yield span((low, foot, -s.z), (high, s.h - top, face), "main", bevel=0.002)
        yield span((-s.x, foot, -s.z), (s.x, s.h - top, -s.z + 0.014), "main")
        yield from closed_block(inner, s.h - top)
        return
    yield span((-s.x + 0.004, foot, -s.z), (s.x - 0.004, s.h - top, face), "main", bevel=0.003)
    body = s.h - top - foot
    rows = max(2, min(5, round(body / st.uniform("row", 0.18, 0.26))))
    columns = 1 if s.w < 0.95 else 2 if s.w < 1.7 else 3
    area = (-s.x + 0.022, s.x - 0.022, foot + 0.012, s.h - top - 0.008)
    if s.h > 1.3:
        split = foot + 0.35 * body
        yield from drawers((*area[:2], area[2], split), face, st, 2, max(1, columns - 1))
        yield from doors((*area[:2], split + 0.01, area[3]), face, st, max(2, columns))
    else:
        yield from drawers(area, face, st, rows, columns)


def shelving(s: Subject) -> Iterator[Part]:
    """Yield a shelving unit."""
    st = s.style
    thick = st.uniform("thick", 0.016, 0.03)
    levels = sorted({round(i.y0, 2) for i in s.inserts if i.kind == "shelf"})
    frame = st.chance("frame", 0.4)
    if not levels:
        count = max(2, min(6, round(s.h / st.uniform("pitch", 0.3, 0.42))))
        first = st.uniform("first", 0.02, 0.12)
        levels = list(np.linspace(first, s.h - thick, count))
    else:
        levels.append(s.h - thick)
    if frame:
        post = st.uniform("post", 0.02, 0.035)
        for sx in (-1, 1):
            for sz in (-1, 1):
                low, high = sorted((sx * s.x, sx * (s.x - post)))
                near, far = sorted((sz * s.z, sz * (s.z - post)))
                yield span((low, 0, near), (high, s.h, far), "metal")
        for end in (-1, 1):
            yield bar(
                (end * (s.x - post / 2), 0.04, -s.z + 0.005),
                (-end * (s.x - post / 2), s.h - 0.04, -s.z + 0.005),
                0.008,
                slot="metal",
                solid=False,
            )
    else:
        for sx in (-1, 1):
            low, high = sorted((sx * s.x, sx * (s.x - thick)))
            yield span((low, 0, -s.z), (high, s.h, s.z), "main", bevel=0.003)
        yield span((-s.x, 0.02, -s.z), (s.x, s.h, -s.z + 0.01), "second")
    for y in levels:
        y = min(y, s.h - thick)
        yield span((-s.x + 0.003, y, -s.z + 0.003), (s.x - 0.003, y + thick, s.z - 0.003), "main", bevel=0.002)
    yield from closed_block(s, s.h - thick)


def shelf(s: Subject) -> Iterator[Part]:
    """Yield a board right below its box, which is the space above: recorded objects rest on the bottom of the box.

    A shelf on a wall has brackets.
    """
    thick = min(0.022, s.h)
    yield span((-s.x, -thick, -s.z), (s.x, 0, s.z), "main", bevel=0.002)
    if s.hung and s.h > 0.06:
        arm = min(0.006, 0.1 * s.w)
        for x in (-0.7 * s.x, 0.7 * s.x):
            top = min(s.h, 0.5 * s.d)
            yield span((x - arm, 0, -s.z), (x + arm, top, -s.z + min(0.008, s.d)), "metal", solid=False)


def cabinet(s: Subject) -> Iterator[Part]:
    """Yield a built-in cupboard: body, one or two doors, and handles where they are reached.

    Handles are low on wall units, high on base units.

    Doors lie in the front face of the box, handles in recesses of the doors: in AI2-THOR, rays meet doors at the box's face.
    """
    thick = min(PANEL_M, 0.3 * s.d)
    face = s.z - thick
    if s.d < 0.09:
        yield span((-s.x, 0, -s.z), (s.x, s.h, face), "main", bevel=0.002)
        yield from _leaf(s, thick, 1)
        return
    foot = 0.0 if s.hung or s.h < 0.4 else 0.04
    sunk = min((i.y0 for i in s.inserts if i.kind == "sink"), default=s.h) - 0.005
    if foot + 0.1 < sunk < s.h - 0.02:
        behind = max(-s.z + 0.01, min(face - 0.02, max(i.z1 for i in s.inserts)))
        yield span((-s.x, foot, -s.z), (s.x, sunk, face), "main", bevel=0.002)
        yield span((-s.x, sunk, behind), (s.x, s.h, face), "main", solid=False)
    else:
        yield span((-s.x, foot, -s.z), (s.x, s.h, face), "main", bevel=0.002)
    if foot:
        yield span((-s.x + 0.002, 0, -s.z), (s.x - 0.002, foot, face - 0.05), "dark", solid=False)
    yield from _leaf(s, thick, 2 if s.w > 0.62 else 1)


def _leaf(s: Subject, thick: float, count: int) -> Iterator[Part]:
    wide = s.w / count
    for i in range(count):
        x0, x1 = -s.x + i * wide + 0.007, -s.x + (i + 1) * wide - 0.007
        foot = 0.007 if s.hung else min(0.042, 0.1 * s.h)
        right = i % 2 == 0 if count > 1 else s.style.chance("opens right", 0.5)
        at = x1 - 0.035 if right else x0 + 0.035
        y = 0.16 * s.h + 0.02 if s.hung else 0.84 * s.h
        yield from pull((x0, x1, foot, s.h - 0.007), s.z, s.style, at, y, True, min(0.14, 0.3 * s.h), thick)


def drawer(s: Subject) -> Iterator[Part]:
    """Front in the face of the box, a handle in its recess, and an open tray behind it."""
    front = min(PANEL_M, 0.2 * s.d)
    face = s.z - front
    thick = 0.012
    yield span((-s.x + 0.004, 0.004, -s.z), (s.x - 0.004, 0.012, face), "second")
    for sx in (-1, 1):
        low, high = sorted((sx * (s.x - 0.004), sx * (s.x - 0.004 - thick)))
        yield span((low, 0.004, -s.z), (high, 0.75 * s.h, face), "second")
    yield span((-s.x + 0.004, 0.004, -s.z), (s.x - 0.004, 0.75 * s.h, -s.z + thick), "second")
    yield span((-s.x, 0, face), (s.x, s.h, s.z), drawn=False)
    at = 0.27 * s.w if s.w > 0.85 else 0.0
    halves = ((-s.x, 0.0, -at), (0.0, s.x, at)) if at else ((-s.x, s.x, 0.0),)
    for x0, x1, x in halves:
        yield from pull((x0, x1, 0.0, s.h), s.z, s.style, x, 0.5 * s.h, False, min(0.16, 0.4 * s.w), front)


def safe(s: Subject) -> Iterator[Part]:
    """Yield a safe."""
    face = s.z - 0.045
    yield span((-s.x, 0, -s.z), (s.x, s.h, face), "main", bevel=0.012)
    yield span((-s.x * 0.84, 0.1 * s.h, face), (s.x * 0.84, 0.9 * s.h, face + 0.012), "second", bevel=0.006, solid=False)
    yield span((-0.16 * s.w, 0.55 * s.h, face), (0.08 * s.w, 0.72 * s.h, face + 0.018), "dark", bevel=0.003, solid=False)
    for i in range(9):
        x, y = -0.12 * s.w + 0.08 * s.w * (i % 3), 0.58 * s.h + 0.045 * s.h * (i // 3)
        yield span((x - 0.015 * s.w, y, face + 0.016), (x + 0.015 * s.w, y + 0.03 * s.h, face + 0.022), "pale", solid=False)
    radius = 0.1 * s.w
    for i in range(3):
        turn = about("z", 120.0 * i)
        yield bar(
            turn @ [0, -0.9 * radius, 0] + [0.18 * s.w, 0.4 * s.h, face + 0.035],
            turn @ [0, 0.9 * radius, 0] + [0.18 * s.w, 0.4 * s.h, face + 0.035],
            0.012,
            slot="metal",
            solid=False,
        )
    yield Part(
        "torus",
        (0.18 * s.w, 0.4 * s.h, face + 0.035),
        (2 * radius, 0.02, 2 * radius),
        about("x", 90.0),
        "metal",
        solid=False,
        ratio=0.2,
    )


FORMS = {
    "Dresser": dresser,
    "ShelvingUnit": shelving,
    "Shelf": shelf,
    "Cabinet": cabinet,
    "Drawer": drawer,
    "Safe": safe,
}
