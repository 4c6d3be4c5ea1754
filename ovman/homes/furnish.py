"""Furniture and things of a home: what a room begins with, loose things, things on tops and on walls."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

from ovman.homes.arrange import Arrangement, Arranger, Placed, turn
from ovman.homes.catalogue import Asset, assets, categories, contents, looks_different, may, weight
from ovman.homes.shell import HEIGHT_MM, Rect, Room, Shell, Side
from ovman.homes.space import Footprint, Space
from ovman.homes.stream import Stream
from ovman.homes.tops import LIFT_MM, find_tops

WALL_GAP_MM = (35, 80)
"""Least and largest distance of a thing from the wall behind it"""
GAP_MM = 40
"""Least distance between things on the floor"""
AISLE_MM = 450
"""Least distance of things in the middle of a room from others"""
USE_MM = 350
"""Floor that stays free before furniture at a wall"""
ABUNDANT_M2 = 8.0
"""Floor for each category of which there are several: small homes have fewer"""
ROUNDS = ("own", "own", "second", "own", "second", "own")
"""Order of placement for each such category: an instance, or a second place of an instance that is placed already"""
COMPACT_MM2 = 900_000
"""Such things cover at most so much floor, so that many of them and their second places fit"""
SPARE_MM = 1700
"""Least distance of a spare place from where the thing stands"""
APART_MM = 2200
"""Distance that loose things of one category keep where there is room: what is two metres away is never taken for the other"""
TRIES = 40
WALLED = frozenset({"Bed", "CounterTop", "Desk", "Dresser", "Fridge", "ShelvingUnit", "Sofa", "TVStand"})
"""Categories that need free floor before them"""
TALL_PLANT_MM = 700
"""Lower plants stand on tops."""
PROGRAMS: dict[str, tuple[tuple[str, float], ...]] = {
    "LivingRoom": (
        ("television-sofa", 1.0), ("chair-diningtable", 0.7), ("lamp-armchair", 0.7), ("ShelvingUnit", 0.6), ("Dresser", 0.4)
    ),
    "Bedroom": (("bed", 1.0), ("Dresser", 1.0), ("desk-with-chair", 0.7), ("lamp-armchair", 0.5), ("ShelvingUnit", 0.4)),
    "Kitchen": (("row", 1.0), ("chair-diningtable", 1.0), ("ShelvingUnit", 0.6), ("SideTable", 0.4)),
    "Study": (
        ("desk-with-chair", 1.0), ("ShelvingUnit", 1.0), ("seat", 0.7), ("desk-with-chair", 0.5), ("chair-diningtable", 0.4)
    ),
}  # fmt: skip
"""Groups and furniture of a kind of room, as `Arranger.draw` names it, and how probable it is"""
IN_THE_MIDDLE = frozenset({"chair-diningtable"})
PER_M2 = {"LivingRoom": (0.78, 1.06), "Bedroom": (0.8, 1.55), "Kitchen": (1.1, 2.0), "Study": (0.78, 1.06)}
"""Movable things per square metre, from and to, by kind of room: in the middle of iTHOR's range (docs/homes.md)"""
PICTURES = {"LivingRoom": (1, 3), "Bedroom": (0, 2), "Kitchen": (0, 0), "Study": (1, 3)}
"""Least and largest number of pictures, as in iTHOR's rooms"""
OPEN = (0.42, 0.52)
"""Share of a room's floor on which a robot can stand, from and to: a room is furnished until it has no more"""
MOST = 4
"""Largest number of things of one category on the floor of a room"""


@dataclass(frozen=True)
class Thing:
    """One object of a home. x, z: middle of its box; y: its bottom; millimetres. parent: id of what it stands on, if any."""

    id: str
    asset: Asset
    x: int
    y: int
    z: int
    yaw_deg: int
    room: int
    parent: str | None = None

    @property
    def rect(self) -> Rect:
        """The rectangle around the floor under its box."""
        return Footprint(self.x, self.z, self.asset.width, self.asset.depth, self.yaw_deg).rect


@dataclass(frozen=True)
class Spare:
    """A second place of a thing, drawn like its own: the floor stays free there, so that the thing can be moved to it."""

    x: int
    z: int
    yaw_deg: int


class Furnisher:
    """Draws the things of one home."""

    def __init__(self, shell: Shell, stream: Stream, split: str) -> None:
        """Begin with empty rooms."""
        self.shell, self.split, self.stream = shell, split, stream
        self.space, self.arranger = Space(shell), Arranger(stream, split)
        self.things: list[Thing] = []
        self.spares: dict[str, Spare] = {}
        self._abundant: frozenset[str] = frozenset()
        self._bare: set[str] = set()
        """Ids of loose things of these categories: nothing stands on them, so that they can change."""

    def furnish(self, abundant: int) -> None:
        """Furnish all rooms."""
        for room in self.shell.rooms:
            for name, probability in PROGRAMS[room.kind]:
                if self.stream.chance(probability):
                    where = ("middle", "middle", "wall") if name in IN_THE_MIDDLE else ("wall",)
                    self._place(partial(self.arranger.draw, name, room.use), room, where)
        area_m2 = sum(room.area_m2 for room in self.shell.rooms)
        self._add_abundant(min(abundant, round(area_m2 / ABUNDANT_M2)))
        for room in self.shell.rooms:
            self._fill_floor(room)
            self._hang_pictures(room)
            self._fill_tops(room)

    def _add(self, asset: Asset, x: int, y: int, z: int, yaw_deg: int, room: Room, parent: str | None = None) -> Thing:
        thing = Thing(f"{asset.category}|{room.number}|{len(self.things)}", asset, x, y, z, yaw_deg % 360, room.number, parent)
        self.things.append(thing)
        return thing

    # The floor

    def _place(
        self, draw: Callable[[], Arrangement | None], room: Room, where: Sequence[str], apart: Collection[Rect] = ()
    ) -> bool:
        """Put a draw of an arrangement at a free place of a room, if one is found; clear of the rectangles `apart`."""
        moved = self._cover_place(draw, room, where, apart)
        self._commit(moved, room)
        return bool(moved)

    def _cover_place(
        self, draw: Callable[[], Arrangement | None], room: Room, where: Sequence[str], apart: Collection[Rect] = ()
    ) -> Arrangement:
        """Find a free place of a room for a draw of an arrangement, and cover the floor there. Empty if none is found."""
        for _ in range(TRIES):
            parts = draw()
            if parts is None:
                continue
            place = self.stream.choice(where)
            spot = self._choose_spot(parts, room, place)
            moved = [part.moved(*spot) for part in parts]
            standing = [part for part in moved if part.above is None]
            if any(part.rect.meets(other) for part in standing for other in apart):
                continue
            before = [_before(part) for part in standing if part.asset.category in WALLED]
            if any(a.meets(b) for a in before for b in self.space.covered):
                continue
            if self.space.fits([part.footprint for part in standing], room, AISLE_MM if place == "middle" else GAP_MM):
                self.space.cover([part.footprint for part in standing])
                self.space.clear += before
                return moved
        return []

    def _choose_spot(self, parts: Arrangement, room: Room, place: str) -> tuple[int, int, int]:
        """Return where the first part comes to stand, x and z, and the yaw of the arrangement."""
        rects = [part.rect for part in parts if part.above is None]
        if place == "middle":
            x, z = (self.stream.integer(low + 600, high - 600, 10) for low, high in zip(room.box[:2], room.box[2:], strict=True))
            return x, z, self.stream.choice([0, 90, 180, 270])
        side = self.stream.choice(room.sides, [s.length for s in room.sides])
        gap = self.stream.integer(*WALL_GAP_MM, 5)
        # A side runs against the x of what stands at it.
        first, last = gap + max(r.x1 for r in rects), side.length - gap + min(r.x0 for r in rects)
        at = self.stream.choice([first, last]) if place == "corner" else self.stream.integer(first, last, 10)
        (ax, az), (ix, iz), deep = side.along, side.inward, gap - min(r.z0 for r in rects)
        return side.start[0] + ax * at + ix * deep, side.start[1] + az * at + iz * deep, side.yaw_deg

    def _commit(self, parts: Arrangement, room: Room) -> None:
        added: list[Thing] = []
        for part in parts:
            if part.above is None:
                added.append(self._add(part.asset, part.x, 0, part.z, part.yaw_deg, room))
                continue
            holder = added[part.above]
            found = find_tops(holder.asset)
            top = holder.y + (found[0].height if found and holder.y == 0 else holder.asset.height)
            added.append(self._add(part.asset, part.x, top - part.sunk + LIFT_MM, part.z, part.yaw_deg, room, holder.id))

    def _add_abundant(self, count: int) -> None:
        """Give `count` categories loose instances that look different, and some of these a second place (ROUNDS)."""
        pools = {
            category: [a for a in self._find_loose(category) if a.width * a.depth <= COMPACT_MM2] for category in categories()
        }
        usual = {c: sum(weight(c, room.use) for room in self.shell.rooms) for c, pool in pools.items() if len(pool) > 1}
        chosen: list[str] = []
        while len(chosen) < count and (left := [c for c in usual if usual[c] and c not in chosen]):
            chosen.append(self.stream.choice(left, [usual[c] * min(len(pools[c]), ROUNDS.count("own")) for c in left]))
        self._abundant = frozenset(chosen)
        for places in ROUNDS:
            for category in chosen:
                loose = [thing for thing in self.things if thing.id in self._bare and thing.asset.category == category]
                if places == "own":
                    self._add_instance(category, pools[category])
                else:
                    any(self._add_spare(thing) for thing in self.stream.shuffled(loose) if thing.id not in self.spares)

    def _add_spare(self, thing: Thing) -> bool:
        """Find a second place for a loose thing; a coin decides at which of the two it stands."""
        room = self.stream.choice([room for room in self.shell.rooms if weight(thing.asset.category, room.use)])
        own = Rect(thing.x, thing.z, thing.x, thing.z).grown(SPARE_MM)
        others = [Rect(t.x, t.z, t.x, t.z).grown(APART_MM) for t in self.things if t.asset.category == thing.asset.category]
        for apart in ([own, *others], [own]):
            for part in self._cover_place(lambda: [Placed(thing.asset)], room, self._find_wheres(thing.asset), apart):
                spare = Spare(part.x, part.z, part.yaw_deg % 360)
                if self.stream.chance(0.5):
                    self.spares[thing.id] = spare
                else:
                    self.spares[thing.id] = Spare(thing.x, thing.z, thing.yaw_deg)
                    stands = replace(thing, x=spare.x, z=spare.z, yaw_deg=spare.yaw_deg, room=room.number)
                    self.things[self.things.index(thing)] = stands
                return True
        return False

    def _find_loose(self, category: str) -> list[Asset]:
        """Return the assets of a category that stand loose on a floor."""
        if not any(may(category, place) for place in ("onFloor", "inCorner", "onEdge")):
            return []
        least = TALL_PLANT_MM if category == "HousePlant" else 0
        return [a for a in assets(category, self.split) if a.loose and a.height >= least]

    def _add_instance(self, category: str, pool: Sequence[Asset]) -> None:
        """Place an asset that looks different from all of its category, if there is one and a free place for it."""
        rooms = [room for room in self.shell.rooms if weight(category, room.use)]
        looks = {thing.asset.id for thing in self.things if thing.asset.category == category}
        for asset in self.stream.shuffled(pool):
            if all(looks_different(asset.id, other) for other in looks):
                before = len(self.things)
                if any(self._place_loose(asset, room) for room in self.stream.shuffled(rooms)):
                    self._bare.add(self.things[before].id)
                    return

    def _place_loose(self, asset: Asset, room: Room) -> bool:
        """Put a thing on the floor, away from others of its category if it can be done."""
        here = [Rect(t.x, t.z, t.x, t.z).grown(APART_MM) for t in self.things if t.asset.category == asset.category]
        return any(self._place(lambda: [Placed(asset)], room, self._find_wheres(asset), apart) for apart in (here, ()))

    def _find_wheres(self, asset: Asset) -> list[str]:
        """Return the kinds of places at which an asset may stand: abundant things stand in the middle as well as at walls."""
        places = {"middle": "inMiddle", "wall": "onEdge", "corner": "inCorner"}
        where = [place for place, key in places.items() if may(asset.category, key)]
        return [*where, "middle", "wall"] if asset.category in self._abundant else [*where, "wall"]

    def _fill_floor(self, room: Room) -> None:
        """Add furniture until robots can stand on a usual share of the floor."""
        share = self.stream.integer(*(round(100 * s) for s in OPEN)) / 100
        known = [c for c in categories() if c not in self._abundant]
        usual = {c: weight(c, room.use) for c in known if may(c, "onFloor") and weight(c, room.use)}
        for _ in range(12):
            counts = Counter(t.asset.category for t in self.things if t.room == room.number)
            left = [c for c in usual if counts[c] < (MOST if may(c, "multiplePerRoom") else 1) and assets(c, self.split)]
            if not left or self.space.share(room) <= share:
                return
            category = self.stream.choice(left, [usual[c] for c in left])
            self._place_loose(self.stream.choice(assets(category, self.split)), room)

    # Tops and walls

    def _fill_tops(self, room: Room) -> None:
        """Put things on tops until the room has as many movable things as rooms of its kind have."""
        low, high = PER_M2[room.kind]
        wanted = round((low + (high - low) * self.stream.integer(0, 100) / 100) * room.area_m2)
        here = [t for t in self.things if t.room == room.number]
        holders = [t for t in here if t.parent is None and t.yaw_deg % 90 == 0 and t.asset.category != "Chair"]
        holders = [t for t in holders if t.id not in self._bare]
        options = [(t, c, p) for t in holders for c, p in contents(t.asset.category).items() if weight(c, room.use)]
        options = [(t, c, p) for t, c, p in options if self._find_small(c, t)]
        taken = {t.id: self._find_covered(t) for t in holders}
        counts = Counter(t.asset.category for t in here)
        missing, fails = wanted - sum(t.asset.movable for t in here), 0
        while options and missing > 0 and fails < 60:
            holder, category, _ = self.stream.choice(options, [p for _, _, p in options])
            usual = may(category, "multiplePerRoom") or counts[category] < 2
            if usual and self._put_on(holder, category, room, taken[holder.id]):
                counts[category] += 1
                missing -= 1
            else:
                fails += 1

    def _find_covered(self, holder: Thing) -> list[Rect]:
        """Return what already stands on a thing, in the frame of the thing at yaw 0."""
        out = []
        for child in (t for t in self.things if t.parent == holder.id):
            x, z = turn(child.x - holder.x, child.z - holder.z, -holder.yaw_deg)
            out.append(Footprint(x, z, child.asset.width, child.asset.depth, (child.yaw_deg - holder.yaw_deg) % 360).rect)
        return out

    def _find_small(self, category: str, holder: Thing) -> list[Asset]:
        most = max(holder.asset.width, holder.asset.depth)
        return [a for a in assets(category, self.split) if a.movable and max(a.width, a.depth) <= most]

    def _put_on(self, holder: Thing, category: str, room: Room, taken: list[Rect]) -> bool:
        """Put a thing of a category on another, if there is room; taken: what stands there, in the frame of the holder."""
        asset = self.stream.choice(self._find_small(category, holder))
        yaw = self.stream.choice([0, 90, 180, 270]) if max(asset.width, asset.depth) < 250 else 0
        width, depth = (asset.width, asset.depth) if yaw % 180 == 0 else (asset.depth, asset.width)
        found = find_tops(holder.asset)
        if not found:
            return False
        top = self.stream.choice(found)
        prints = [Footprint(x, z, width, depth, 0).rect for x, z in top.find_spots(width, asset.height, depth)]
        near = [other.grown(15) for other in taken]
        prints = [rect for rect in prints if not any(map(rect.meets, near))]
        if not prints:
            return False
        rect = self.stream.choice(prints)
        taken.append(rect)
        x, z = turn((rect.x0 + rect.x1) // 2, (rect.z0 + rect.z1) // 2, holder.yaw_deg)
        self._add(asset, holder.x + x, top.height + LIFT_MM, holder.z + z, holder.yaw_deg + yaw, room, holder.id)
        return True

    def _hang_pictures(self, room: Room) -> None:
        """Hang pictures on free stretches of the walls, each once in a room."""
        for asset in self.stream.shuffled(assets("Painting", self.split))[: self.stream.integer(*PICTURES[room.kind])]:
            sides = [side for side in room.sides if side.length > asset.width + 800]
            for _ in range(TRIES if sides else 0):
                side = self.stream.choice(sides)
                first = self.stream.integer(200, side.length - 200 - asset.width, 10)
                last = first + asset.width
                bottom = max(self._height(side, first, last) + 150, 1500 - asset.height // 2)
                if bottom + asset.height < HEIGHT_MM - 150 and side.is_bare(first, last):
                    side.taken.append((first, last))
                    at = side.strip(first, last, 4, 4 + asset.depth)
                    self._add(asset, (at.x0 + at.x1) // 2, bottom, (at.z0 + at.z1) // 2, side.yaw_deg, room)
                    break

    def _height(self, side: Side, first: int, last: int) -> int:
        """Return how high things stand before a stretch of a wall."""
        strip = side.strip(first, last, 0, 500)
        return max((t.y + t.asset.height for t in self.things if t.room == side.room and t.rect.meets(strip)), default=0)


def _before(part: Placed) -> Rect:
    """Return the floor before the front of a part, which stays free."""
    rect, (x, z) = part.rect, turn(0, 1, part.yaw_deg)
    deep = Rect(rect.x0 + x * USE_MM, rect.z0 + z * USE_MM, rect.x1 + x * USE_MM, rect.z1 + z * USE_MM)
    return Rect(
        max(deep.x0, rect.x1) if x > 0 else deep.x0,
        max(deep.z0, rect.z1) if z > 0 else deep.z0,
        min(deep.x1, rect.x0) if x < 0 else deep.x1,
        min(deep.z1, rect.z0) if z < 0 else deep.z1,
    )
