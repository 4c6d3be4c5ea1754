"""Fronts of furniture: drawers, doors, panels, handles, and the body behind fronts that are objects of their own."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.plan.counters import Rect, without
from ovman_engine.shapes.part import Part, arc, rod, span, tube
from ovman_engine.shapes.style import Style
from ovman_engine.shapes.subject import Subject

Area = tuple[float, float, float, float]
"""x low, x high, y low, y high, metres"""

HANDLE_M = 0.028
"""How far handles stand out of a front."""
PANEL_M = 0.018
"""Thickness of a front."""
GROOVE_M = 0.006
"""Width of the groove between the frame of a front and its field."""
GRIP_M = 0.034
"""Width of the recess in which a handle lies."""


def handle(
    x: float, y: float, face: float, style: Style, upright: bool, length: float, reach: float = HANDLE_M
) -> Iterator[Part]:
    """Yield a handle centred at (x, y) on a front whose face is at z = `face`, standing out by `reach`; form by asset."""
    form = style.choice("handle", ("bar", "bar", "knob", "bow", "cup"))
    half = length / 2
    dx, dy = (0.0, half) if upright else (half, 0.0)
    if form == "knob":
        radius = min(0.016, reach * 0.6)
        yield rod((x, y, face), (x, y, face + reach * 0.6), radius * 0.45, "metal", solid=False)
        yield Part("ellipsoid", (x, y, face + reach * 0.7), (2 * radius, 2 * radius, reach * 0.6), slot="metal", solid=False)
    elif form == "bow":
        plane = "yz" if upright else "xz"
        path = arc((0, 0, 0), 1.0, 0, 180, plane, 9) * [dx or 1, dy or 1, reach - 0.005] + [x, y, face]
        yield tube(path, 0.005, "metal", solid=False)
    elif form == "cup":
        yield span(
            (x - dx - 0.004, y - dy - 0.012, face),
            (x + dx + 0.004, y + dy + 0.012, face + reach),
            "metal",
            kind="cushion",
            ratio=0.5,
            solid=False,
        )
    else:
        radius = min(0.006, reach * 0.25)
        z = face + reach - radius
        yield rod((x - dx, y - dy, z), (x + dx, y + dy, z), radius, "metal", solid=False)
        for end in (-0.8, 0.8):
            at = (x + end * dx, y + end * dy)
            yield rod((*at, face), (*at, z), radius * 0.8, "metal", solid=False)


def panel(
    area: Area, face: float, style: Style, slot: str = "second", thick: float = PANEL_M, hole: Area | None = None
) -> Iterator[Part]:
    """Yield a front of `area` standing out to z = `face`: flat, framed by a groove, or raised.

    Open where a handle lies in `hole`.
    """
    x0, x1, y0, y1 = area
    back = face - thick
    form = style.choice("front", ("flat", "flat", "framed", "framed", "raised"))
    rail = min(0.05, 0.2 * (x1 - x0), 0.2 * (y1 - y0))
    field = (x0 + rail, x1 - rail, y0 + rail, y1 - rail)
    rails = ((x0, x0 + rail, y0, y1), (x1 - rail, x1, y0, y1), (*field[:2], y0, y0 + rail), (*field[:2], y1 - rail, y1))
    if form == "flat" or rail < 0.018:
        layers = [(area, face, 0.003)]
    elif form == "framed":
        groove = min(GROOVE_M, 0.2 * rail)
        inner = (field[0] + groove, field[1] - groove, field[2] + groove, field[3] - groove)
        layers = [(area, face - 0.5 * thick, 0.0), *((one, face, 0.002) for one in rails), (inner, face, 0.002)]
    else:
        layers = [(area, face - 0.33 * thick, 0.003), (field, face, 0.006)]
    for (low, high, under, top), front, bevel in layers:
        if hole is None:
            yield span((low, under, back), (high, top, front), slot, bevel=bevel, solid=False)
            continue
        pieces = without(Rect(low, under, high, top), (Rect(hole[0], hole[2], hole[1], hole[3]),))
        for left, foot, right, head in pieces:
            cut = bevel if len(pieces) == 1 else 0.0
            yield span((left, foot, back), (right, head, front), slot, bevel=cut, solid=False)


def pull(
    area: Area, face: float, style: Style, x: float, y: float, upright: bool, length: float, thick: float = PANEL_M
) -> Iterator[Part]:
    """Yield a front of `area` standing out to z = `face`, with a handle centred at (x, y).

    The handle lies in a recess and not before it.
    """
    wide, high = (GRIP_M / 2, length / 2 + 0.012) if upright else (length / 2 + 0.012, GRIP_M / 2)
    hole = (max(x - wide, area[0]), min(x + wide, area[1]), max(y - high, area[2]), min(y + high, area[3]))
    yield from panel(area, face, style, thick=thick, hole=hole)
    floor = face - 0.9 * thick
    yield span((hole[0], hole[2], face - thick), (hole[1], hole[3], floor), "dark", solid=False)
    yield from handle(x, y, floor, style, upright, length, face - floor)


def drawers(area: Area, face: float, style: Style, rows: int, columns: int, reach: float = HANDLE_M) -> Iterator[Part]:
    """Yield a grid of drawer fronts over `area` of a body whose face is at z = `face`; fronts and handles stand out of it."""
    x0, x1, y0, y1 = area
    gap = 0.006
    wide, high = (x1 - x0) / columns, (y1 - y0) / rows
    two_handles = wide > 0.7
    for i in range(rows):
        for j in range(columns):
            cell = (x0 + j * wide + gap, x0 + (j + 1) * wide - gap, y0 + i * high + gap, y0 + (i + 1) * high - gap)
            yield from panel(cell, face + PANEL_M * 0.6, style)
            middle, level = (cell[0] + cell[1]) / 2, (cell[2] + cell[3]) / 2
            for offset in (-0.27, 0.27) if two_handles else (0.0,):
                yield from handle(
                    middle + offset * wide,
                    level,
                    face + PANEL_M * 0.6,
                    style,
                    False,
                    min(0.14, 0.4 * wide),
                    min(reach, 0.3 - PANEL_M) - PANEL_M * 0.6,
                )


def doors(area: Area, face: float, style: Style, count: int, reach: float = HANDLE_M) -> Iterator[Part]:
    """`count` doors side by side over `area`; their handles are at the opening edges."""
    x0, x1, y0, y1 = area
    wide = (x1 - x0) / count
    for i in range(count):
        cell = (x0 + i * wide + 0.003, x0 + (i + 1) * wide - 0.003, y0 + 0.003, y1 - 0.003)
        yield from panel(cell, face + PANEL_M * 0.6, style)
        opens_right = i % 2 == 0
        x = cell[1] - 0.035 if opens_right else cell[0] + 0.035
        yield from handle(x, (y0 + y1) / 2, face + PANEL_M * 0.6, style, True, min(0.16, 0.4 * (y1 - y0)), reach - PANEL_M * 0.6)


def closed_block(s: Subject, top: float) -> Iterator[Part]:
    """Yield the body behind drawers and doors that are objects of their own.

    It goes up to height `top`, its face just behind their fronts.
    """
    fronts = [i for i in s.inserts if i.kind != "shelf"]
    groups: list[list[float]] = []
    for i in sorted(fronts, key=lambda f: f.x0):
        if groups and i.x0 < groups[-1][1] + 0.06:
            group = groups[-1]
            group[1], group[2], group[3] = max(group[1], i.x1), min(group[2], i.y0), max(group[3], i.y1)
            group[4] = min(group[4], i.z1)
        else:
            groups.append([i.x0, i.x1, i.y0, i.y1, i.z1])
    shelves = [i for i in s.inserts if i.kind == "shelf"]
    for x0, x1, y0, y1, face in groups:
        inside = (max(-s.x + 0.004, x0 - 0.015), max(0.0, y0 - 0.015), min(s.x - 0.004, x1 + 0.015), min(top, y1 + 0.015))
        if any(i.y0 > y0 and i.y1 < y1 and i.x0 < x1 and i.x1 > x0 for i in shelves):
            continue
        front = min(face - 0.03, s.z - 0.012)
        if front > -s.z + 0.03 and inside[3] > inside[1] and inside[2] > inside[0]:
            yield span((inside[0], inside[1], -s.z + 0.004), (inside[2], inside[3], front), "main", bevel=0.002)
