"""Curtains, blinds and rugs of a house, none of which its description lists.

They follow from the building, never from the objects in it, so that they look the same on every visit. They are drawn but do
not collide, so they stay close to walls, floor and ceiling.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ovman_engine.paint import finishes
from ovman_engine.paint.finishes import Finish, Material
from ovman_engine.paint.tones import CLOTHS
from ovman_engine.plan.floorplan import FloorPlan
from ovman_engine.plan.house import House, HouseRoom, Opening, WallSide, largest_rectangle, side
from ovman_engine.plan.houseplan import FRAME_M, hole
from ovman_engine.room.room import Structure
from ovman_engine.shapes.hangings import curtains
from ovman_engine.shapes.part import Part, moved, rod, span
from ovman_engine.shapes.style import Style
from ovman_engine.shapes.subject import Subject

WET_ROOMS = frozenset({"Kitchen", "Bathroom"})
"""Rooms with blinds in place of curtains, and without rugs."""
CURTAIN_M, BLIND_M = 0.06, 0.04
"""Depth of curtains and of blinds, in front of the frame of the window."""
ASIDE_M, ABOVE_M, BELOW_M = 0.14, 0.1, 0.12
"""How far curtains reach beyond the window."""
GATHERED = 0.16
"""Share of the window behind each of its two curtains."""
RAISED = (0.15, 0.35)
"""Share of the window that a blind covers."""
RUGS = 0.35
"""Share of large rooms with a rug"""
RUG_M = 0.001
"""Thickness of a rug: no object that lies on the floor is thinner."""
RUG_SIDE_M, RUG_SHARE = (1.1, 1.6, 2.4), 0.55
"""Least length of a rug and largest width and length; largest share of a side of the floor."""
border = finishes.of(*CLOTHS, texture="fabric", scale=(0.02, 0.04), gloss=(0.0, 0.02))
rug = finishes.patterned(
    border,
    0.6,
    (("print", 0.15, 0.3), ("weave", 0.02, 0.03)),
)


def furnish(plan: FloorPlan) -> list[Structure]:
    """Return curtains, blinds and rugs of all rooms of `plan`, which carries a house, in the world frame."""
    house = plan.house
    assert house is not None  # the caller has a house
    rooms = {room.name: room for room in house.rooms}
    out = []
    for opening in house.openings:
        wall = next((w for w in house.walls if w.name in opening.walls and w.room in rooms and "exterior" not in w.name), None)
        if opening.window and wall is not None:
            out.append(_dress_window(plan, house, opening, wall, rooms[wall.room]))
    for room in house.rooms:
        out += [] if room.kind in WET_ROOMS else _lay_rug(plan, house, room)
    return out


def _paint(finish: Finish, key: str) -> Material:
    return replace(finish(Style(key)), seed=Style(key).integer("seed") % 2**31)


def _dress_window(plan: FloorPlan, house: House, opening: Opening, wall: WallSide, room: HouseRoom) -> Structure:
    """Return the blind or the curtains of a window. All windows of a room have the same."""
    low, high = hole(opening, wall)
    wide, tall, key = float(np.linalg.norm((high - low)[[0, 2]])), float(high[1] - low[1]), f"{room.name}|curtains"
    style = Style(f"{house.name}|{key}")
    if room.kind in WET_ROOMS:
        bottom, deep = high[1] - style.uniform("raised", *RAISED) * tall, BLIND_M
        parts = _blind(wide / 2, float(high[1] - bottom))
        cloth = finishes.linen
    else:
        bottom, deep = max(low[1] - BELOW_M, 0.02), CURTAIN_M
        height = min(high[1] + ABOVE_M, house.height - 0.02) - bottom
        parts, cloth = _curtains(wide, float(height), style), finishes.drapery
    key = f"{plan.name}|{key}"
    palette = {"cloth": _paint(cloth, key), "metal": _paint(finishes.metal, f"{key}|rail")}
    x, z = wall.along * side(wall, house)
    turn = np.array([[x, 0.0, -z], [0.0, 1.0, 0.0], [z, 0.0, x]])
    middle = (low + high) / 2 + turn @ [0.0, 0.0, (FRAME_M + deep) / 2]
    hung = moved((part for part in parts if part.drawn), turn, (middle[0], bottom, middle[2]))
    return f"curtains|{opening.name}", hung, palette


def _blind(half: float, height: float) -> list[Part]:
    """Return a roller blind: a roll, a sheet of cloth below it and a rod at its end."""
    roll = BLIND_M / 2
    return [
        rod((-half, height - roll, 0), (half, height - roll, 0), roll, "cloth"),
        span((-half, 0.0, -0.003), (half, height - roll, 0.003), "cloth"),
        rod((-half, 0.0, 0), (half, 0.0, 0), 0.012, "metal"),
    ]


def _curtains(wide: float, height: float, style: Style) -> list[Part]:
    """Return a rail and two curtains drawn aside, centred on a window `wide` metres wide."""
    half, panel, rail = wide / 2 + ASIDE_M, ASIDE_M + GATHERED * wide, 0.012
    parts = [rod((-half, height - rail, 0), (half, height - rail, 0), rail, "metal")]
    for at in (panel / 2 - half, half - panel / 2):
        parts += moved(curtains(Subject("Curtains", panel, height, CURTAIN_M, style)), by=(at, 0.0, 0.0))
    return parts


def _lay_rug(plan: FloorPlan, house: House, room: HouseRoom) -> list[Structure]:
    """Return a rug in the middle of the largest rectangle of a room, if it is large enough for one."""
    x_0, x_1, z_0, z_1 = largest_rectangle(room)
    sides, (least, width, length) = np.array([x_1 - x_0, z_1 - z_0]), RUG_SIDE_M
    style = Style(f"{house.name}|{room.name}|rug")
    size = np.minimum(RUG_SHARE * sides, np.where(sides == sides.max(), length, width)) * style.uniform("size", 0.8, 1.0)
    if size.min() < least or not style.chance("rug", RUGS):
        return []
    round_ = style.chance("round", 0.2)
    if round_:
        size[:] = size.min()
    middle = np.array([(x_0 + x_1) / 2, (z_0 + z_1) / 2])
    parts = [_flat(middle, size, RUG_M, "second", round_), _flat(middle, size - 0.16, 1.5 * RUG_M, "main", round_)]
    key = f"{plan.name}|{room.name}|rug"
    paints = {"main": _paint(rug, key), "second": _paint(border, f"{key}|border")}
    return [(f"rug|{room.name}", tuple(parts), paints)]


def _flat(middle: np.ndarray, size: np.ndarray, top: float, slot: str, round_: bool) -> Part:
    (x_0, z_0), (x_1, z_1) = middle - size / 2, middle + size / 2
    return span((x_0, 0.0, z_0), (x_1, top, z_1), slot, kind="cylinder" if round_ else "box", segments=48 if round_ else 0)
