"""Rooms, walls, doors and windows of a home, in millimetres on the floor plane (x, z); sides run clockwise seen from above."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ovman.homes.catalogue import Asset, assets, database
from ovman.homes.stream import Stream

KINDS = ("LivingRoom", "Bedroom", "Kitchen", "Study")
AREA_M2 = {1: (35, 45), 2: (20, 32), 3: (15, 24)}
"""Least and largest area of a room, by the number of rooms"""
SIDE_MM = (3600, 8000)
"""Least and largest side of a room"""
STEP_MM = 50
HEIGHT_MM = 2700
SILL_MM = 900
DOOR_CLEAR_MM = 900
"""Floor before a door that stays free"""
JAMB_MM = 300
"""Least distance of a robot's centre from the sides of a passage, which has a frame"""
ACCENT = 0.4
"""Share of rooms with one wall of another colour"""
MARGIN_MM = 250
"""Least distance of a door or window from the end of its wall"""

Point = tuple[int, int]


class Rect(NamedTuple):
    """A rectangle on the floor plane, millimetres."""

    x0: int
    z0: int
    x1: int
    z1: int

    @property
    def area_m2(self) -> float:
        """Area in square metres."""
        return (self.x1 - self.x0) * (self.z1 - self.z0) / 1e6

    def grown(self, by: int) -> Rect:
        """Return it with `by` more on every side."""
        return Rect(self.x0 - by, self.z0 - by, self.x1 + by, self.z1 + by)

    def meets(self, other: Rect) -> bool:
        """Whether the two have an area in common."""
        return self.x0 < other.x1 and other.x0 < self.x1 and self.z0 < other.z1 and other.z0 < self.z1

    def holds(self, other: Rect) -> bool:
        """Whether the other is inside."""
        return self.x0 <= other.x0 and other.x1 <= self.x1 and self.z0 <= other.z0 and other.z1 <= self.z1


@dataclass(frozen=True)
class Side:
    """One side of a room: from `start` to `end`, with the room on its right. taken: stretches with doors, windows, pictures."""

    room: int
    start: Point
    end: Point
    taken: list[tuple[int, int]] = field(default_factory=list, compare=False)

    @property
    def length(self) -> int:
        """Length in millimetres."""
        return abs(self.end[0] - self.start[0]) + abs(self.end[1] - self.start[1])

    @property
    def along(self) -> Point:
        """Unit vector from start to end."""
        return (self.end[0] - self.start[0]) // self.length, (self.end[1] - self.start[1]) // self.length

    @property
    def inward(self) -> Point:
        """Unit vector into the room."""
        x, z = self.along
        return z, -x

    @property
    def yaw_deg(self) -> int:
        """Yaw of a thing with its back to the wall."""
        return {(0, 1): 0, (1, 0): 90, (0, -1): 180, (-1, 0): 270}[self.inward]

    @property
    def id(self) -> str:
        """ProcTHOR's name of the wall."""
        ends = [(min(pair) / 1000, max(pair) / 1000) for pair in zip(self.start, self.end, strict=True)]
        return f"wall|{self.room}|" + "|".join(f"{value:.2f}" for k in (0, 1) for value in (ends[0][k], ends[1][k]))

    @property
    def outer_id(self) -> str:
        """ProcTHOR's name of the outer face of the wall."""
        return self.id.replace(f"wall|{self.room}", "wall|exterior")

    def is_bare(self, first: int, last: int) -> bool:
        """Whether a stretch of the wall has no door, window or picture."""
        return all(last + 100 < a or b + 100 < first for a, b in self.taken)

    def strip(self, first: int, last: int, near: int, far: int) -> Rect:
        """Return the rectangle from `first` to `last` along the side, and from `near` to `far` into the room."""
        (ax, az), (ix, iz) = self.along, self.inward
        corners = [(self.start[0] + ax * u + ix * v, self.start[1] + az * u + iz * v) for u in (first, last) for v in (near, far)]
        xs, zs = zip(*corners, strict=True)
        return Rect(min(xs), min(zs), max(xs), max(zs))


@dataclass(frozen=True)
class Room:
    """A room: a rectangle, less `notch` in one of its corners. number: as in ProcTHOR's ids, from 2."""

    number: int
    kind: str
    box: Rect
    notch: Rect | None
    sides: tuple[Side, ...]

    @staticmethod
    def of(number: int, kind: str, corners: Sequence[Point]) -> Room:
        """Return the room with these corners, clockwise seen from above."""
        box = _bounds(corners)
        missing = [(x, z) for x in (box.x0, box.x1) for z in (box.z0, box.z1) if (x, z) not in corners]
        inner = [(x, z) for x, z in corners if box.x0 < x < box.x1 and box.z0 < z < box.z1]
        notch = _bounds([*missing, *inner]) if inner else None
        ends = zip(corners, [*corners[1:], corners[0]], strict=True)
        return Room(number, kind, box, notch, tuple(Side(number, start, end) for start, end in ends))

    @property
    def area_m2(self) -> float:
        """Area of its floor."""
        return self.box.area_m2 - (0.0 if self.notch is None else self.notch.area_m2)

    def contains(self, rect: Rect) -> bool:
        """Whether a rectangle is in the room."""
        return self.box.holds(rect) and not (self.notch is not None and self.notch.meets(rect))

    @property
    def use(self) -> str:
        """The kind of room whose rules of ProcTHOR it follows. ProcTHOR has no studies."""
        return "LivingRoom" if self.kind == "Study" else self.kind


def _bounds(points: Sequence[Point]) -> Rect:
    xs, zs = zip(*points, strict=True)
    return Rect(min(xs), min(zs), max(xs), max(zs))


@dataclass
class Shell:
    """The rooms of a home with its openings. clear: floor that stays free; ways: floor in passages on which a robot can stand."""

    rooms: tuple[Room, ...]
    doors: list[dict[str, Any]] = field(default_factory=list)
    windows: list[dict[str, Any]] = field(default_factory=list)
    clear: list[Rect] = field(default_factory=list)
    ways: list[Rect] = field(default_factory=list)


def draw_shell(stream: Stream, count: int, split: str) -> Shell:
    """Draw the rooms of a home with their doors and windows."""
    outlines = _mirrored(stream, {1: _draw_one, 2: _draw_two, 3: _draw_three}[count](stream))
    kinds = stream.shuffled(KINDS)[:count]
    if count > 1:  # one enters by a living room or a kitchen, if there is one
        kinds.sort(key=lambda kind: kind not in ("LivingRoom", "Kitchen"))
    rooms = tuple(Room.of(k + 2, kind, corners) for k, (kind, corners) in enumerate(zip(kinds, outlines, strict=True)))
    shell = Shell(rooms)
    for first, second in _pairs(rooms):
        _add_passage(stream, shell, split, first, second)
    sides = [side for room in rooms for side in room.sides]
    outer = [side for side in sides if not any(_back_to_back(side, other) for other in sides)]
    _add_front_door(stream, shell, split, [side for side in outer if side.room == 2])
    for room in rooms:
        _add_windows(stream, shell, split, room, [side for side in outer if side.room == room.number])
    return shell


Outline = list[Point]
"""Corners of a room, clockwise seen from above"""


def _rectangle(x0: int, z0: int, x1: int, z1: int) -> Outline:
    return [(x0, z0), (x0, z1), (x1, z1), (x1, z0)]


def _ell(width: int, depth: int, x: int, z: int) -> Outline:
    """Return a rectangle at the origin without its upper right corner, which begins at (x, z)."""
    return [(0, 0), (0, depth), (x, depth), (x, z), (width, z), (width, 0)]


def _mirrored(stream: Stream, outlines: list[Outline]) -> list[Outline]:
    """Return the rooms of a home mirrored along x, along z, both or not at all."""
    box = _bounds([point for outline in outlines for point in outline])
    if stream.chance(0.5):
        outlines = [[(box.x1 - x, z) for x, z in outline][::-1] for outline in outlines]
    if stream.chance(0.5):
        outlines = [[(x, box.z1 - z) for x, z in outline][::-1] for outline in outlines]
    return outlines


def _draw_sides(stream: Stream, low_m2: float, high_m2: float) -> tuple[int, int]:
    """Return width and depth of a rectangle with an area in the range."""
    while True:
        width, depth = (stream.integer(*SIDE_MM, STEP_MM) for _ in range(2))
        if low_m2 <= width * depth / 1e6 <= high_m2 and max(width, depth) <= 1.6 * min(width, depth):
            return width, depth


def _draw_one(stream: Stream) -> list[Outline]:
    low, high = AREA_M2[1]
    if stream.chance(0.7):
        return [_rectangle(0, 0, *_draw_sides(stream, low, high))]
    while True:
        width, depth = _draw_sides(stream, low * 1.15, high * 1.25)
        outline = _ell(
            width, depth, *(stream.integer(s * 3 // 5, s * 3 // 4, STEP_MM) // STEP_MM * STEP_MM for s in (width, depth))
        )
        if low <= Room.of(2, "", outline).area_m2 <= high:
            return [outline]


def _draw_two(stream: Stream) -> list[Outline]:
    """Return two rooms side by side, or one in a corner of the other."""
    low, high = AREA_M2[2]
    width, depth = _draw_sides(stream, low, high)
    if stream.chance(0.6):
        while not low <= (other := stream.integer(*SIDE_MM, STEP_MM)) * depth / 1e6 <= high:
            pass
        return [_rectangle(0, 0, width, depth), _rectangle(width, 0, width + other, depth)]
    while True:
        x, z = (stream.integer(2800, 5000, STEP_MM) for _ in range(2))
        ell = _ell(x + width, z + depth, x, z)
        if Room.of(2, "", ell).area_m2 <= AREA_M2[1][1]:
            return [ell, _rectangle(x, z, x + width, z + depth)]


def _draw_three(stream: Stream) -> list[Outline]:
    """Return a room along one side of the home, and two beside it."""
    low, high = AREA_M2[3]
    while True:
        width, other = (stream.integer(*SIDE_MM, STEP_MM) for _ in range(2))
        depth = stream.integer(2 * SIDE_MM[0], 9000, STEP_MM)
        at = stream.integer(SIDE_MM[0], depth - SIDE_MM[0], STEP_MM)
        beside = [other * at / 1e6, other * (depth - at) / 1e6]
        if low <= width * depth / 1e6 <= 1.5 * high and all(low <= area <= high for area in beside):
            x = width + other
            first = [(0, 0), (0, depth), (width, depth), (width, at), (width, 0)]
            return [first, _rectangle(width, 0, x, at), _rectangle(width, at, x, depth)]


def _back_to_back(side: Side, other: Side) -> bool:
    return side.start == other.end and side.end == other.start


def _pairs(rooms: Sequence[Room]) -> list[tuple[Side, Side]]:
    """Return for each room but the first the longest side that it shares with an earlier room."""
    found = []
    for k, room in enumerate(rooms[1:], start=1):
        shared = [(a, b) for r in rooms[:k] for a in r.sides for b in room.sides if _back_to_back(a, b)]
        found.append(max(shared, key=lambda pair: pair[0].length))
    return found


def _metres(**millimetres: int) -> dict[str, float]:
    return {axis: value / 1000 for axis, value in millimetres.items()}


def _opening(asset: Asset, side: Side, first: int, sill: int, name: str, other: Side | None) -> dict[str, Any]:
    """Return a door or window as ProcTHOR writes it. Along its wall it begins `first` after the start."""
    last = first + asset.width
    side.taken.append((first, last))
    return {
        "id": name,
        "assetId": asset.id,
        "room0": f"room|{side.room}",
        "room1": f"room|{side.room if other is None else other.room}",
        "wall0": side.id,
        "wall1": side.outer_id if other is None else other.id,
        "boundingBox": {
            "min": _metres(x=first, y=sill, z=0),
            "max": _metres(x=last, y=sill + asset.height, z=asset.depth),
        },
        "assetOffset": _metres(x=0, y=0, z=0),
        "openable": False,
        "openness": 0,
    }


def _add_passage(stream: Stream, shell: Shell, split: str, side: Side, other: Side) -> None:
    """Add a way through two sides back to back: a frame without a door."""
    frames = [a for a in assets("Doorframe", split) if a.width <= side.length - 2 * MARGIN_MM]
    asset = stream.choice(frames)
    first = stream.integer(MARGIN_MM, side.length - MARGIN_MM - asset.width, 10)
    shell.doors.append(_opening(asset, side, first, 0, f"door|{side.room}|{other.room}", other))
    back = side.length - first - asset.width
    other.taken.append((back, back + asset.width))
    shell.clear += [one.strip(at, at + asset.width, 0, DOOR_CLEAR_MM) for one, at in ((side, first), (other, back))]
    shell.ways.append(side.strip(first + JAMB_MM, first + asset.width - JAMB_MM, -300, 300))


def _add_front_door(stream: Stream, shell: Shell, split: str, sides: Sequence[Side]) -> None:
    """Add a shut door to the outside."""
    asset = stream.choice([a for a in assets("Doorway", split) if a.width < 1500])
    side = stream.choice([s for s in sides if s.length > asset.width + 2 * MARGIN_MM])
    first = stream.integer(MARGIN_MM, side.length - MARGIN_MM - asset.width, 10)
    shell.doors.append(_opening(asset, side, first, 0, f"door|1|{side.room}", None) | {"openable": True})
    shell.clear.append(side.strip(first, first + asset.width, 0, DOOR_CLEAR_MM))


def _add_windows(stream: Stream, shell: Shell, split: str, room: Room, sides: Sequence[Side]) -> None:
    """Add up to two windows of one asset on different outer sides of a room."""
    fixed = [a for a in assets("Window", split) if a.depth < 300 and SILL_MM + a.height < HEIGHT_MM - 200]
    asset, count = stream.choice(fixed), stream.integer(1, 2)
    for number, side in enumerate(stream.shuffled([s for s in sides if s.length >= asset.width + 2 * MARGIN_MM])[:count]):
        spots = range(MARGIN_MM, side.length - MARGIN_MM - asset.width + 1, 50)
        free = [first for first in spots if side.is_bare(first, first + asset.width)]
        if free:
            name = f"window|{room.number}|{number}"
            shell.windows.append(_opening(asset, side, stream.choice(free), SILL_MM, name, None))


def write_walls(shell: Shell, paint: Mapping[str, Mapping[str, Any]], outside: str) -> list[dict[str, Any]]:
    """Return the walls of a home as ProcTHOR writes them. Walls to the outside have another face there, of material `outside`."""
    inner = {(side.start, side.end) for room in shell.rooms for side in room.sides}
    out = []
    for side in (side for room in shell.rooms for side in room.sides):
        corners = [(*point, y) for y in (0, HEIGHT_MM) for point in (side.start, side.end)]
        polygon = [_metres(x=x, y=y, z=z) for x, z, y in corners]
        out.append({"id": side.id, "roomId": f"room|{side.room}", "polygon": polygon, **paint[side.id]})
        if (side.end, side.start) not in inner:
            face = {"id": side.outer_id, "roomId": f"room|{side.room}", "polygon": polygon[::-1], "material": outside}
            out.append(face)
    return out


def choose_paint(stream: Stream, rooms: Sequence[Room]) -> dict[str, dict[str, Any]]:
    """Return material and colour of each wall, by its name. Some rooms have one wall of another colour."""
    colours = database("solid-wall-colors.json")
    paint: dict[str, dict[str, Any]] = {}
    for room in rooms:
        main, accent = stream.choice(colours), stream.choice(colours)
        chosen = stream.choice(room.sides).id if stream.chance(ACCENT) else ""
        paint |= {s.id: {"material": "PureWhite", "color": accent if s.id == chosen else main} for s in room.sides}
    return paint
