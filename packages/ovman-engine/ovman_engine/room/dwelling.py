"""The room of a house: walls with holes for doors and windows, and ceilings, as the house describes them.

A wall of a house has two sides back to back, one for the room on each side; each is seen from its own room.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ovman_engine.paint import finishes
from ovman_engine.paint.finishes import Material
from ovman_engine.plan.floorplan import Box, FloorPlan
from ovman_engine.plan.house import House, Opening, WallSide, largest_rectangle, rectangles, side
from ovman_engine.plan.houseplan import hole
from ovman_engine.room import interior
from ovman_engine.room.masonry import SKIRTING_M, TILED, WALLS
from ovman_engine.room.room import Room, Structure, Wall, lamp, structure_name
from ovman_engine.shapes.part import Part, span
from ovman_engine.shapes.style import Style

SHEET_M = 0.002
"""Thickness of a wall side as it is drawn: pictures hang 5 mm in front of it."""
SOLID_M = 0.05
"""Thickness of a wall as it collides."""
CEILING_M = 0.05
MOST_LAMPS = 7
"""Largest number of rooms with a ceiling lamp."""
SKIRTING_DEPTH_M = 0.008
ON_M = 0.05
"""An opening this close to the line of a wall side is in that wall."""
MIN_M = 1e-3

Span = tuple[float, float, float, float]
"""(low, high, bottom, top): distances along a wall side from its start, and heights, metres"""


@dataclass(frozen=True)
class Dwelling(Room):
    """A house as a room."""

    @staticmethod
    def of(plan: FloorPlan) -> Dwelling:
        """Return the room of `plan`, which carries a house."""
        house = plan.house
        corners = np.concatenate([room.polygon for room in house.rooms])
        low, high = corners.min(axis=0), corners.max(axis=0)
        outline = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
        taken = {o.object_id for o in plan.objects}
        walls = [wall for sheet in house.walls if not sheet.empty for wall in _solids(sheet, house)]
        solid = tuple(replace(wall, name=_unique(wall.name, taken)) for wall in walls)
        return Dwelling(plan, outline, outline, (), solid, solid, house.height)

    def lamps(self) -> tuple[np.ndarray, ...]:
        """Return a lamp in each of the largest rooms, over the middle of the largest rectangle."""
        middles = [largest_rectangle(room) for room in self.plan.house.rooms]
        middles.sort(key=lambda m: -(m[1] - m[0]) * (m[3] - m[2]))
        return tuple(np.array([(a + b) / 2, self.plan.house.height, (c + d) / 2]) for a, b, c, d in middles[:MOST_LAMPS])

    def parts(self) -> tuple[Structure, ...]:
        """Walls with skirting boards, ceilings with lamps, and what hangs and lies in the rooms."""
        house, taken = self.plan.house, {o.object_id for o in self.plan.objects}
        out: list[Structure] = []
        for sheet in house.walls:
            parts = () if sheet.empty else _drawn(sheet, house)
            if parts:
                out.append((_unique(sheet.name, taken), parts, _paint(self.plan, sheet)))
        if house.walls:
            white = finishes.of((0.1, 0.08, 0.92), (0.6, 0.03, 0.92), gloss=(0.03, 0.05), slack=0.02)
            ceiling = {"main": white(Style(f"{self.plan.name}|ceiling"))}
            for room in house.rooms:
                boxes = [span((a, house.height, c), (b, house.height + CEILING_M, d)) for a, b, c, d in rectangles(room)]
                out.append((_unique(f"ceiling|{room.name}", taken), tuple(boxes), ceiling))
            for at in self.lamps():
                out.append((_unique(structure_name("ceiling", at), taken), *lamp(self, at)))
            out += [(_unique(name, taken), parts, palette) for name, parts, palette in interior.furnish(self.plan)]
        return tuple(out)


def _holes(sheet: WallSide, house: House) -> list[tuple[Opening, Span]]:
    """Return openings in a wall side, whichever side of the wall names them."""
    walls = {w.name: w for w in house.walls}
    out = []
    for opening in house.openings:
        low, high = hole(opening, walls[opening.walls[0]])
        ends = np.array([low, high])[:, [0, 2]] - sheet.start
        off = np.abs(ends @ [-sheet.along[1], sheet.along[0]])
        first, last = np.sort(ends @ sheet.along)
        if off.max() < ON_M and last > MIN_M and first < sheet.length - MIN_M:
            out.append((opening, (float(first), float(last), float(low[1]), float(high[1]))))
    return out


def _without(sheet: WallSide, holes: Sequence[Span]) -> list[Span]:
    """Return the wall side without holes: upright strips between the sides of the holes, each cut at its holes."""
    edges = sorted({0.0, sheet.length, *(float(np.clip(e, 0.0, sheet.length)) for h in holes for e in h[:2])})
    out = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        if high - low < MIN_M:
            continue
        height = sheet.bottom
        for _, _, sill, lintel in sorted((h for h in holes if h[0] < high - 1e-6 and h[1] > low + 1e-6), key=lambda h: h[2]):
            if sill - height > MIN_M:
                out.append((low, high, height, min(sill, sheet.top)))
            height = max(height, lintel)
        if sheet.top - height > MIN_M:
            out.append((low, high, height, sheet.top))
    return out


def _box(sheet: WallSide, piece: Span, middle: float, thick: float) -> Box:
    """Return a piece of a wall side, shifted `middle` metres to the left of its line (to +z for a line along +x)."""
    low, high, bottom, top = piece
    x, z = sheet.along
    left = np.array([-z, x])
    centre = sheet.start + sheet.along * (low + high) / 2 + left * middle
    turn = np.array([[x, 0.0, -z], [0.0, 1.0, 0.0], [z, 0.0, x]])
    half = np.array([high - low, top - bottom, thick]) / 2
    return Box(np.array([centre[0], (bottom + top) / 2, centre[1]]), half, turn)


def _solids(sheet: WallSide, house: House) -> list[Wall]:
    """Return the colliding pieces of a wall side, without open doors. Their names differ."""
    pieces = _without(sheet, [at for opening, at in _holes(sheet, house) if opening.passable])
    return [Wall(f"{sheet.name}|{k}" if k else sheet.name, _box(sheet, piece, 0.0, SOLID_M)) for k, piece in enumerate(pieces)]


def _drawn(sheet: WallSide, house: House) -> tuple[Part, ...]:
    """Return the visible face of a wall side, with a skirting board in a room."""
    towards, pieces = side(sheet, house), _without(sheet, [at for _, at in _holes(sheet, house)])
    boxes = [("main", _box(sheet, piece, towards * SHEET_M / 2, SHEET_M)) for piece in pieces]
    for low, high, bottom, top in pieces if "exterior" not in sheet.name else ():
        if bottom == sheet.bottom and top > bottom + SKIRTING_M:
            board = low, high, bottom, bottom + SKIRTING_M
            boxes.append(("trim", _box(sheet, board, towards * SKIRTING_DEPTH_M / 2, SKIRTING_DEPTH_M)))
    return tuple(Part("box", box.centre, 2 * box.half, box.rotation, slot) for slot, box in boxes)


def _unique(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "|"
    taken.add(name)
    return name


def _paint(plan: FloorPlan, sheet: WallSide) -> Mapping[str, Material]:
    """Return the palette of a wall side. Sides of one material look alike in a house."""
    style = Style(f"{plan.name}|{sheet.paint}|{sheet.colour}")
    made = finishes.of(*WALLS, gloss=(0.03, 0.08), slack=0.03)(style)
    if sheet.colour is not None and "~" not in plan.name:
        display = np.array(sheet.colour)
        made = replace(made, colour=np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4))
    kind = next((room.kind.lower() for room in plan.house.rooms if room.name == sheet.room), "")
    room = Style(f"{plan.name}|{sheet.room}")
    if kind in TILED and "exterior" not in sheet.name and room.chance("tiles", 0.5):
        made = replace(made, texture="tiles", scale_m=room.uniform("tile", 0.1, 0.24))
    trim = finishes.either(*(finishes.white_paint,) * 4, finishes.wood)(Style(f"{plan.name}|trim"))
    return {"main": replace(made, seed=style.integer("seed") % 2**31), "trim": trim}
