"""Furniture that stands together: ProcTHOR's groups, and beds, seats and kitchen rows made of its assets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from ovman.homes.catalogue import Asset, Group, Part, assets, groups
from ovman.homes.shell import Rect
from ovman.homes.space import Footprint
from ovman.homes.stream import Stream

BESIDE_MM = 20
"""Least distance between parts of a group"""
KNEES_MM = (300, 450)
"""Distance of a coffee table from the sofa"""
ROW_MM = 2400
"""Length that the counters of a kitchen row have together, as far as whole ones reach"""
STAND_MM = (650, 800)
"""Largest side and height of a night stand"""


def turn(x: int, z: int, yaw_deg: int) -> tuple[int, int]:
    """Return a point (x, z) after a turn about the origin by a multiple of 90 degrees."""
    return {0: (x, z), 90: (z, -x), 180: (-x, -z), 270: (-z, x)}[yaw_deg % 360]


@dataclass(frozen=True)
class Placed:
    """An asset at a place. x, z: middle of its box, millimetres; above: index of the part of the arrangement that it stands on.

    In an arrangement, the first part is at the origin with yaw 0 and its back at -z. sunk: how far it is let into what holds it.
    """

    asset: Asset
    x: int = 0
    z: int = 0
    yaw_deg: int = 0
    above: int | None = None
    sunk: int = 0

    @property
    def footprint(self) -> Footprint:
        """The floor under its box."""
        return Footprint(self.x, self.z, self.asset.width, self.asset.depth, self.yaw_deg % 360)

    @property
    def rect(self) -> Rect:
        """The rectangle around that."""
        return self.footprint.rect

    def moved(self, x: int, z: int, yaw_deg: int) -> Placed:
        """Return it after a turn about the origin and a shift."""
        dx, dz = turn(self.x, self.z, yaw_deg)
        return replace(self, x=x + dx, z=z + dz, yaw_deg=(self.yaw_deg + yaw_deg) % 360)


Arrangement = list[Placed]


class Arranger:
    """Draws arrangements from the assets of a split."""

    def __init__(self, stream: Stream, split: str) -> None:
        """Draw from `stream`."""
        self._stream, self._split = stream, split

    def _find_groups(self, name: str = "") -> list[Group]:
        """Return the groups whose names begin so and whose parts the split has."""
        found = [group for group in groups() if group.name.startswith(name)]
        return [g for g in found if all(self._pool(part) for part in g.parts)]

    def _pool(self, part: Part) -> list[Asset]:
        return [a for a in assets(part.category, self._split) if a.id in part.assets]

    def draw(self, name: str, use: str) -> Arrangement | None:
        """Return a draw of a group, a bed, a seat, a kitchen row, or one asset of a category. None if the parts overlap."""
        own: dict[str, Callable[[], Arrangement]] = {"bed": self._bed, "row": self._row, "seat": self._seat}
        if name in own:
            return _apart(own[name]())
        found = self._find_groups(name)
        if found:
            usual = [g for g in found if g.weights[use]] or found
            return _apart(self._group(self._stream.choice(usual)))
        return [Placed(self._stream.choice(assets(name, self._split)))]

    def _group(self, group: Group) -> Arrangement:
        out: Arrangement = []
        chosen: dict[str, Asset] = {}
        for part in group.parts:
            asset = chosen.setdefault(part.name, self._stream.choice(self._pool(part)))
            if part.parent is None:
                out.append(Placed(asset))
                continue
            yaw = (part.yaw_deg + self._stream.integer(-part.jitter_deg, part.jitter_deg)) % 360
            out.append(_attach(part, Placed(asset, yaw_deg=yaw), out[part.parent]))
        sofa = next((p for p in out if p.asset.category == "Sofa"), None)
        return out if sofa is None else [*out, *self._coffee(sofa)]

    def _coffee(self, sofa: Placed) -> Arrangement:
        """Return a coffee table before a sofa, or none."""
        table = self._stream.choice(assets("CoffeeTable", self._split))
        deep = sofa.asset.depth // 2 + self._stream.integer(*KNEES_MM, 10) + table.depth // 2
        x, z = turn(0, deep, sofa.yaw_deg)
        return [Placed(table, sofa.x + x, sofa.z + z, sofa.yaw_deg)] if self._stream.chance(0.8) else []

    def _seat(self) -> Arrangement:
        sofa = Placed(self._stream.choice(assets("Sofa", self._split)))
        return [sofa, *self._coffee(sofa)]

    def _bed(self) -> Arrangement:
        """Return a bed with pillows and up to two night stands."""
        pillows = [group for group in self._find_groups() if group.name.endswith("-pillow")]
        out = self._group(self._stream.choice(pillows))
        bed = next(p for p in out if p.above is None)
        side, height = STAND_MM
        stands = [a for a in assets("SideTable", self._split) if max(a.width, a.depth) <= side and a.height <= height]
        stand = self._stream.choice(stands)
        for right in (-1, 1):
            x = right * (bed.asset.width // 2 + stand.width // 2 + self._stream.integer(60, 120, 10))
            if self._stream.chance(0.75):
                out.append(Placed(stand, x, stand.depth // 2 - bed.asset.depth // 2))
        return out

    def _row(self) -> Arrangement:
        """Return a kitchen row: counters with a sink and a tap, and a fridge beside them."""
        straight = [a for a in assets("CounterTop", self._split) if a.depth < 700]
        counter = self._stream.choice([a for a in straight if a.width > 1000] or straight)
        room = (counter.width - 60, 300, counter.depth - 60)
        sinks = [a for a in assets("Sink", self._split) if all(map(int.__lt__, (a.width, a.height, a.depth), room))]
        sink, fridge = self._stream.choice(sinks), self._stream.choice(assets("Fridge", self._split))
        taps = [a for a in assets("Faucet", self._split) if a.depth < sink.depth - 40 and a.width < sink.width]
        tap = self._stream.choice(taps)
        slack = (counter.width - sink.width) // 2 - 30
        x = self._stream.integer(-slack, slack, 10) if slack > 0 else 0
        side = self._stream.choice([-1, 1])
        out = [
            Placed(counter),
            Placed(sink, x, above=0, sunk=sink.height - 10),
            Placed(tap, x, (tap.depth - sink.depth) // 2 + 10, above=1),
            Placed(fridge, side * (counter.width + fridge.width + 60) // 2, (fridge.depth - counter.depth) // 2),
        ]
        more = max(0, ROW_MM // counter.width - 1)
        return out + [Placed(counter, -side * k * (counter.width + 4)) for k in range(1, more + 1)]


def _attach(part: Part, own: Placed, parent: Placed) -> Placed:
    """Return a part of a group at its place by its parent: next to it as the group says, but never pushed under it."""
    box, half = parent.rect, (own.rect.x1, own.rect.z1)
    at = []
    for k in (0, 1):
        middle, reach = (box[k] + box[k + 2]) // 2, (box[k + 2] - box[k]) // 2
        place = part.side[k] * reach + part.offset[k] + part.align[k] * half[k]
        if not part.above and part.side[k] and part.align[k] != -part.side[k]:
            place = part.side[k] * max(reach + half[k] + BESIDE_MM, part.side[k] * place)
        at.append(middle + place)
    return replace(own, x=at[0], z=at[1], above=part.parent if part.above else None)


def _apart(parts: Arrangement) -> Arrangement | None:
    """Return the arrangement, None if two parts on the floor overlap."""
    rects = [p.rect for p in parts if p.above is None]
    return None if any(a.meets(b) for k, a in enumerate(rects) for b in rects[:k]) else parts
