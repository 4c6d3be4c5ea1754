"""Walls, doors and ceiling of an inferred room as parts in the world frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ovman_engine.paint import finishes
from ovman_engine.paint.finishes import Material
from ovman_engine.paint.tones import Tone
from ovman_engine.room.room import Room, Structure, lamp, structure_name
from ovman_engine.shapes.part import Part
from ovman_engine.shapes.style import Style

THICK_M = 0.1
MIN_THICKNESS_M = 0.02
"""A block that stands out less than this is not drawn; its items hang on the wall behind."""
SKIRTING_M, SKIRTING_DEPTH_M = 0.09, 0.015
CORNICE_M = (0.06, 0.04)
"""Height and depth of a cornice."""
LAMP_AREA_M2, MOST_LAMPS = 18.0, 2
"""Floor area of one ceiling lamp, and the largest number of lamps."""
SUNK_M, PROUD_M = 0.4, 0.1
"""A window this far behind the face of a wall, or in front of it, is in that wall."""
DOOR_M = (0.86, 2.04)
"""Width and height of a door."""
DOOR_FRAME_M = 0.07
DOOR_FROM_SWITCH_M = 0.22
DOOR_CLEAR_M = 0.3
"""No object stands this close in front of a door."""

Opening = tuple[float, float, float, float]
"""(low, high, bottom, top): along a face, and heights, metres"""


@dataclass(frozen=True)
class Face:
    """A visible vertical face of a wall."""

    axis: int
    """0: the plane is x = `plane`, and the face runs along z; 1: the plane is z = `plane`, and it runs along x"""
    outwards: int
    """Direction along the axis in which the body of the wall lies"""
    plane: float
    low: float
    high: float
    thick: float

    def box(self, low: float, high: float, bottom: float, top: float, first: float, last: float, slot: str) -> Part:
        """Return a part from depth `first` to depth `last` in the wall; negative depths are in front of it."""
        a, b = sorted((self.plane + self.outwards * first, self.plane + self.outwards * last))
        x, z = ((a, b), (low, high)) if self.axis == 0 else ((low, high), (a, b))
        least, most = np.array([x[0], bottom, z[0]]), np.array([x[1], top, z[1]])
        return Part("box", (least + most) / 2, most - least, slot=slot)


def structures(room: Room) -> tuple[Structure, ...]:
    """All walls, the door and the ceiling of `room`."""
    style = Style(f"{room.plan.name}|room")
    faces = _faces(room)
    out: list[Structure] = []
    accent = style.choice("accent wall", (None, None, (0, -1), (0, 1), (1, -1), (1, 1)))
    for face in faces:
        paint = _paint(style, "accent" if (face.axis, face.outwards) == accent else "wall", room.plan.kind)
        parts = _wall_parts(room, face, _openings(room, face))
        if parts:
            out.append((_unique("wall", parts, out), parts, paint))
    out += _doors(room, faces, style, out)
    x_0, z_0, x_1, z_1 = room.outline
    least = np.array([x_0 - THICK_M, room.ceiling_y, z_0 - THICK_M])
    most = np.array([x_1 + THICK_M, room.ceiling_y + THICK_M, z_1 + THICK_M])
    ceiling = (Part("box", (least + most) / 2, most - least),)
    out.append((_unique("ceiling", ceiling, out), ceiling, _paint(style, "ceiling", room.plan.kind)))
    for at in lamps(room):
        parts, paint = lamp(room, at)
        out.append((_unique("ceiling", parts, out), parts, paint))
    return tuple(out)


def lamps(room: Room) -> tuple[np.ndarray, ...]:
    """Return the places of ceiling lamps, along the longer side of the room."""
    low, high = np.array(room.outline).reshape(2, 2)
    size = high - low
    count = int(np.clip(round(size.prod() / LAMP_AREA_M2), 1, MOST_LAMPS))
    long, found = int(size[1] > size[0]), []
    for k in range(count):
        x, z = np.where(np.arange(2) == long, low + size * (k + 0.5) / count, low + size / 2)
        found.append(np.array([x, room.ceiling_y, z]))
    return tuple(found)


def _unique(kind: str, parts: Sequence[Part], others: Iterable[Structure]) -> str:
    low = np.min([p.centre - p.size / 2 for p in parts], axis=0)
    high = np.max([p.centre + p.size / 2 for p in parts], axis=0)
    centre, taken = (low + high) / 2, {name for name, _, _ in others}
    while structure_name(kind, centre) in taken:
        centre = centre + [0.0, 0.01, 0.0]
    return structure_name(kind, centre)


def _faces(room: Room) -> list[Face]:
    """Return the four sides of the outline, then the front and the sides of each block that stands out from them."""
    x_0, z_0, x_1, z_1 = room.outline
    faces = [
        Face(0, -1, x_0, z_0 - THICK_M, z_1 + THICK_M, THICK_M),
        Face(0, 1, x_1, z_0 - THICK_M, z_1 + THICK_M, THICK_M),
        Face(1, -1, z_0, x_0, x_1, THICK_M),
        Face(1, 1, z_1, x_0, x_1, THICK_M),
    ]
    drawn: set[tuple[float, ...]] = set()
    for block in room.blocks:
        side = room.outline[block.axis if block.outwards < 0 else 2 + block.axis]
        depth = min(block.outwards * (side - block.plane), block.thick)
        low = max(block.low, room.outline[1 - block.axis])
        high = min(block.high, room.outline[3 - block.axis])
        key = (block.axis, block.outwards, round(block.plane, 2), round(low, 2), round(high, 2))
        if depth < MIN_THICKNESS_M or high - low < MIN_THICKNESS_M or key in drawn:
            continue
        drawn.add(key)
        thick = min(THICK_M, depth)
        faces.append(Face(block.axis, block.outwards, block.plane, low, high, thick))
        if block.thick < np.inf:
            back = block.plane + block.outwards * block.thick
            faces.append(Face(block.axis, -block.outwards, back, low, high, block.thick - thick))
        ends = sorted((block.plane + block.outwards * thick, block.plane + block.outwards * depth))
        width = min(THICK_M, (high - low) / 2)
        for outwards, at in ((1, low), (-1, high)):
            if ends[1] - ends[0] > MIN_THICKNESS_M and room.outline[1 - block.axis] < at < room.outline[3 - block.axis]:
                faces.append(Face(1 - block.axis, outwards, at, ends[0], ends[1], width))
    return faces


def _openings(room: Room, face: Face) -> list[Opening]:
    out = []
    for obj in room.plan.objects:
        if obj.type != "Window":
            continue
        low, high = obj.box.bounds()
        first, last = (low[[0, 2]], high[[0, 2]])
        into = sorted((face.outwards * (first[face.axis] - face.plane), face.outwards * (last[face.axis] - face.plane)))
        along = 1 - face.axis
        flat = (last - first)[face.axis] <= (last - first)[along]
        if flat and into[0] < SUNK_M and into[1] > -PROUD_M and first[along] < face.high and last[along] > face.low:
            out.append((float(first[along]), float(last[along]), float(low[1]), float(high[1])))
    return out


def _wall_parts(room: Room, face: Face, openings: Sequence[Opening]) -> tuple[Part, ...]:
    """Upright strips between the sides of the openings, each cut at its openings; skirting boards and cornices."""
    bottom, top = room.floor_y - 0.05, room.ceiling_y
    edges = sorted({face.low, face.high, *(min(max(e, face.low), face.high) for o in openings for e in o[:2])})
    parts = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        if high - low < 1e-4:
            continue
        height = bottom
        for _, _, sill, lintel in sorted((o for o in openings if o[0] < high - 1e-6 and o[1] > low + 1e-6), key=lambda o: o[2]):
            if sill - height > 1e-3:
                parts.append(face.box(low, high, height, min(sill, top), 0.0, face.thick, "main"))
            height = max(height, lintel)
        if top - height > 1e-3:
            parts.append(face.box(low, high, height, top, 0.0, face.thick, "main"))
        if not any(o[0] < high - 1e-6 and o[1] > low + 1e-6 and o[2] < room.floor_y + SKIRTING_M for o in openings):
            parts.append(face.box(low, high, room.floor_y, room.floor_y + SKIRTING_M, -SKIRTING_DEPTH_M, 0.0, "trim"))
        if height < top - CORNICE_M[0]:
            for k in (1, 2):  # two steps
                parts.append(face.box(low, high, top - CORNICE_M[0] / k, top, -CORNICE_M[1] * k / 2, 0.0, "cornice"))
    return tuple(parts)


def _doors(room: Room, faces: Sequence[Face], style: Style, others: Sequence[Structure]) -> list[Structure]:
    """Return a closed door beside the light switch, which is where switches are, if it fits."""
    bounds = [(o.type, *o.box.bounds()) for o in room.plan.objects if o.type not in ("Floor", "LightSwitch")]
    width = DOOR_M[0] + 2 * DOOR_FRAME_M
    for switch in (o for o in room.plan.objects if o.type == "LightSwitch"):
        low, high = switch.box.bounds()
        for face in faces:
            along = 2 if face.axis == 0 else 0
            across = 2 - along
            middle = float(low[across] + high[across]) / 2
            if abs(middle - face.plane) > PROUD_M or not face.low < (low[along] + high[along]) / 2 < face.high:
                continue
            for begin in (float(high[along]) + DOOR_FROM_SWITCH_M, float(low[along]) - DOOR_FROM_SWITCH_M - width):
                end = begin + width
                if begin < face.low + THICK_M or end > face.high - THICK_M:
                    continue
                space = face.box(begin, end, room.floor_y, room.floor_y + DOOR_M[1], -DOOR_CLEAR_M, face.thick, "main")
                least, most = space.centre - space.size / 2, space.centre + space.size / 2
                if any((b[1] < most).all() and (b[2] > least).all() for b in bounds):
                    continue
                if any(_crosses(other, face, begin, end) for other in faces if other is not face):
                    continue
                parts = _door_parts(room, face, begin, end, style)
                return [(_unique("door", parts, others), parts, _paint(style, "door", room.plan.kind))]
    return []


def _crosses(other: Face, face: Face, begin: float, end: float) -> bool:
    """Whether another face is in front of `face` between `begin` and `end`."""
    if other.axis == face.axis:
        before = face.outwards * (face.plane - other.plane)
        return other.outwards == face.outwards and before > 1e-6 and other.low < end and other.high > begin
    return (
        begin - THICK_M < other.plane < end + THICK_M and other.low < face.plane + PROUD_M and other.high > face.plane - PROUD_M
    )


def _door_parts(room: Room, face: Face, begin: float, end: float, style: Style) -> tuple[Part, ...]:
    floor, height, f = room.floor_y, DOOR_M[1], DOOR_FRAME_M
    parts = [
        face.box(begin, begin + f, floor, floor + height + f, -0.03, 0.0, "trim"),
        face.box(end - f, end, floor, floor + height + f, -0.03, 0.0, "trim"),
        face.box(begin + f, end - f, floor + height, floor + height + f, -0.03, 0.0, "trim"),
        face.box(begin + f, end - f, floor + 0.01, floor + height, -0.012, 0.0, "main"),
    ]
    rows = style.whole("door panels", 1, 3)
    for k in range(rows):
        low = floor + 0.15 + k * (height - 0.25) / rows
        high = floor + 0.05 + (k + 1) * (height - 0.25) / rows
        parts.append(face.box(begin + f + 0.12, end - f - 0.12, low, high, -0.02, -0.012, "second"))
    knob = begin + f + 0.06 if style.chance("door hand", 0.5) else end - f - 0.06
    parts.append(face.box(knob - 0.02, knob + 0.02, floor + 0.98, floor + 1.06, -0.016, -0.012, "metal"))
    parts.append(face.box(knob - 0.05, knob + 0.05, floor + 1.0, floor + 1.02, -0.06, -0.045, "metal"))
    parts.append(face.box(knob - 0.01, knob + 0.01, floor + 1.0, floor + 1.02, -0.05, -0.012, "metal"))
    return tuple(parts)


WALLS: tuple[Tone, ...] = (
    (0.10, 0.14, 0.88),
    (0.12, 0.22, 0.82),
    (0.09, 0.12, 0.76),
    (0.60, 0.05, 0.80),
    (0.60, 0.06, 0.68),
    (0.28, 0.12, 0.72),
    (0.54, 0.16, 0.78),
    (0.04, 0.22, 0.82),
    (0.13, 0.34, 0.80),
    (0.08, 0.16, 0.64),
)
"""White, cream, greige, greys, sage, pale blue, blush, butter, taupe."""
FEATURES: tuple[Tone, ...] = (
    (0.61, 0.30, 0.34),
    (0.38, 0.22, 0.34),
    (0.04, 0.36, 0.52),
    (0.60, 0.06, 0.32),
    (0.11, 0.40, 0.58),
    (0.49, 0.26, 0.42),
    (0.98, 0.24, 0.42),
)
"""Tones of an accent wall: navy, forest, terracotta, charcoal, ochre, teal, plum."""
TILED = frozenset({"kitchen", "bathroom"})


def _paint(style: Style, what: str, kind: str) -> Mapping[str, Material]:
    """Return the palette of a structure, drawn from the name of the scene. `kind`: of room."""
    draw = {
        "wall": finishes.of(*WALLS, gloss=(0.03, 0.08), slack=0.03),
        "accent": finishes.of(*FEATURES, gloss=(0.03, 0.08), slack=0.05),
        "ceiling": finishes.of((0.1, 0.08, 0.92), (0.6, 0.03, 0.92), gloss=(0.03, 0.05), slack=0.02),
        "door": finishes.either(finishes.white_paint, finishes.white_paint, finishes.wood, finishes.wood, finishes.painted),
    }[what]
    main = draw(Style(f"{style.key}|{what}"))
    if what in ("wall", "accent"):
        plain = ("plain",) * (2 if kind in TILED else 7)
        texture = style.choice(f"{what} texture", (*plain, "tiles", "tiles") if kind in TILED else (*plain, "speckle", "speckle"))
        scale = (0.1, 0.24) if texture == "tiles" else (0.006, 0.01)
        main = replace(main, texture=texture, scale_m=style.uniform(f"{what} scale", *scale))
    main = replace(main, seed=style.integer(f"{what} seed") % 2**31)
    second = replace(main, colour=main.colour * 0.9)
    trim = finishes.either(*(finishes.white_paint,) * 4, finishes.wood)(Style(f"{style.key}|trim"))
    cornice = finishes.white_paint(Style(f"{style.key}|cornice"))
    return {
        "main": main,
        "second": second,
        "trim": trim,
        "cornice": cornice,
        "metal": finishes.metal(Style(f"{style.key}|handle")),
    }
