"""Free places on a receptacle: its upward faces, with the free height above them, on a grid in plan.

All is measured on the boxes around collision pieces, which a dome does not fill. So a place is a proposal, and physics decides.
World frame as in `floorplan`; plan coordinates are (x, z), metres.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ovman_engine.bodies.body import Body
from ovman_engine.bodies.forms import extent
from ovman_engine.bodies.static_scene import StaticScene

FINEST_M, COARSEST_M, CELLS = 0.025, 0.1, 1500
"""Least and largest spacing of a grid, metres; between them, a receptacle has about CELLS cells."""
LEVEL_M = 0.01
"""Faces within this height of each other are one surface."""
UPRIGHT = 0.999
"""Cosine above which a face counts as level."""
HIGHEST_M = 2.0
"""Largest free height that is measured."""
VESSELS = frozenset(
    [
        "Bathtub",
        "BathtubBasin",
        "Bowl",
        "Box",
        "Cabinet",
        "CoffeeMachine",
        "Cup",
        "Drawer",
        "Fridge",
        "GarbageCan",
        "LaundryHamper",
        "Microwave",
        "Mug",
        "Pan",
        "Pot",
        "Safe",
        "Sink",
        "SinkBasin",
        "Toaster",
    ]
)
"""Types that hold objects inside rather than on top."""
BRIM_M, BRIM = 0.05, 0.2
"""A face is inside a vessel if it is this far below its top, or this fraction of its height."""
SEATS = frozenset(["ArmChair", "Bed", "Chair", "DogBed", "Sofa"])
"""Types whose largest face holds objects: backs and arms do not."""
TIERED = frozenset(["CoffeeTable", "Floor", "Shelf", "ShelvingUnit", "SideTable", "TVStand"])
"""Types of which several faces hold objects; of all other types the highest face does."""
HUTCHED = frozenset(["Desk"])
"""Types that may have shelves over their tops: faces in their upper half hold objects."""
MIN_M = (0.02, 0.05)
"""Least half width and free height of a face that counts."""


@dataclass(frozen=True)
class Level:
    """An upward surface. `room` (X, Z) is the free height above each cell, metres, 0 beside the surface."""

    height: float
    corner: np.ndarray
    """(2,) centre of the first cell"""
    spacing: float
    room: np.ndarray

    def fitting(self, half: Sequence[float], height: float) -> np.ndarray:
        """Return the centres (N, 2) of the cells at which a box of half extents `half` (2,) and `height` can stand.

        It stands wholly on the surface, free of everything that was there when the level was measured.
        """
        wanted = self.room >= height
        reach = [int(np.ceil(h / self.spacing - 0.5 + 1e-9)) for h in half]
        sizes = [2 * max(r, 0) + 1 for r in reach]
        if any(s > n for s, n in zip(sizes, wanted.shape, strict=True)):
            return np.zeros((0, 2))
        total = np.zeros((wanted.shape[0] + 1, wanted.shape[1] + 1), dtype=int)
        total[1:, 1:] = wanted.cumsum(axis=0).cumsum(axis=1)
        a, b = sizes
        count = total[a:, b:] - total[:-a, b:] - total[a:, :-b] + total[:-a, :-b]
        cells = np.argwhere(count == a * b) + [max(r, 0) for r in reach]
        return self.corner + cells * self.spacing


@dataclass(frozen=True)
class Pieces:
    """Boxes around N pieces, in columns: centre, half (N, 3), rotation (N, 3, 3), bounds low, high (N, 3)."""

    centre: np.ndarray
    half: np.ndarray
    rotation: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @staticmethod
    def of(static: StaticScene, bodies: Iterable[Body]) -> Pieces:
        """Return the pieces of bodies at their current poses. Bodies without pieces have none here."""
        centres, halves, rotations = [], [], []
        for body in bodies:
            made = static.pieces[body.obj.object_id]
            box = body.box
            for piece in made:
                centre, half, rotation = extent(piece)
                centres.append(box.centre + box.rotation @ centre)
                halves.append(half)
                rotations.append(box.rotation @ rotation)
        centre = np.array(centres).reshape(-1, 3)
        half, rotation = np.array(halves).reshape(-1, 3), np.array(rotations).reshape(-1, 3, 3)
        reach = np.einsum("nij,nj->ni", np.abs(rotation), half)
        return Pieces(centre, half, rotation, centre - reach, centre + reach)

    def take(self, index: np.ndarray) -> Pieces:
        """Return the pieces at `index` (integers or a mask)."""
        return Pieces(self.centre[index], self.half[index], self.rotation[index], self.low[index], self.high[index])

    def __len__(self) -> int:
        """Return number of pieces."""
        return len(self.centre)

    def levels(self) -> list[tuple[float, np.ndarray]]:
        """(height, indices) of upward faces; faces within LEVEL_M of the highest of a group belong together."""
        flat = np.flatnonzero(np.abs(self.rotation[:, 1, :]).max(axis=1) > UPRIGHT)
        out: list[tuple[float, list[int]]] = []
        for k in flat[np.argsort(-self.high[flat, 1], kind="stable")].tolist():
            if out and out[-1][0] - self.high[k, 1] < LEVEL_M:
                out[-1][1].append(k)
            else:
                out.append((float(self.high[k, 1]), [k]))
        return [(height, np.array(found)) for height, found in out]

    def covers(self, k: int, points: np.ndarray) -> np.ndarray:
        """(...) bool: which plan points (..., 2) piece `k` covers."""
        turn, half = self.rotation[k], self.half[k]
        up = int(np.abs(turn[1]).argmax())
        if abs(turn[1, up]) <= UPRIGHT:
            return np.asarray(((points >= self.low[k, [0, 2]]) & (points <= self.high[k, [0, 2]])).all(axis=-1))
        away = points - self.centre[k, [0, 2]]
        inside = np.ones(points.shape[:-1], dtype=bool)
        for axis in (a for a in range(3) if a != up):
            inside &= np.abs(away @ turn[[0, 2], axis]) <= half[axis]
        return inside


def holding(world, receptacle: Body, ignoring: Collection[str] = ()) -> tuple[Level, ...]:
    """Return the `levels` of `receptacle` that hold objects on a receptacle of its type, highest first."""
    half, height = MIN_M
    kind, found = receptacle.obj.type, levels(world, receptacle, ignoring)
    if kind in VESSELS:
        low, high = (float(corner[1]) for corner in receptacle.box.bounds())
        found = tuple(level for level in found if high - level.height >= min(BRIM_M, BRIM * (high - low)))
    sizes = [len(level.fitting((half, half), height)) for level in found]
    found = tuple(level for level, size in zip(found, sizes, strict=True) if size)
    if not found or kind in TIERED or kind in VESSELS:
        return found
    if kind in HUTCHED:
        return tuple(level for level in found if level.height > receptacle.box.centre[1])
    return (found[int(np.argmax([size for size in sizes if size]))],) if kind in SEATS else found[:1]


def levels(world, receptacle: Body, ignoring: Collection[str] = ()) -> tuple[Level, ...]:
    """Surfaces of `receptacle` in `world`, highest first, with the height that all bodies but `ignoring` leave free."""
    static = StaticScene.of(world.plan)
    floor = receptacle.obj.type == "Floor"
    others = Pieces.of(
        static,
        (b for b in world.bodies.values() if b.present and b is not receptacle and b.object_id not in ignoring
         and b.obj.type != "Floor"),
    )  # fmt: skip
    if floor:
        x_0, z_0, x_1, z_1 = world.room.outline
        first, last = (corner[[0, 2]] for corner in receptacle.box.bounds())
        low, high = np.maximum([x_0, z_0], first), np.minimum([x_1, z_1], last)
        found = [(world.plan.floor_y, np.zeros(0, dtype=int))]
        own = others.take(np.zeros(0, dtype=int))
    else:
        own = Pieces.of(static, [receptacle])
        if not len(own):
            return ()
        low, high = own.low[:, [0, 2]].min(axis=0), own.high[:, [0, 2]].max(axis=0)
        found = own.levels()
    spacing = float(np.clip(np.sqrt(np.prod(high - low) / CELLS), FINEST_M, COARSEST_M))
    counts = np.maximum(np.floor((high - low) / spacing).astype(int), 1)
    corner = (low + high) / 2 - (counts - 1) * spacing / 2
    points = corner + np.stack(np.meshgrid(np.arange(counts[0]), np.arange(counts[1]), indexing="ij"), axis=-1) * spacing
    near = (others.low[:, [0, 2]] < high).all(axis=1) & (others.high[:, [0, 2]] > low).all(axis=1)
    others = others.take(near)
    out = []
    for height, surface in found:
        room = np.full(tuple(counts), HIGHEST_M if floor else 0.0)
        for k in surface.tolist():
            room[own.covers(k, points)] = HIGHEST_M
        for block in (own, others):
            for k in np.flatnonzero((block.high[:, 1] > height + LEVEL_M) & (block.low[:, 1] < height + HIGHEST_M)).tolist():
                cells = _cells(block, k, corner, spacing, counts)
                part = room[cells]
                if part.size and part.any():
                    free = max(float(block.low[k, 1]) - height, 0.0)
                    part[block.covers(k, points[cells])] = np.minimum(part, free)[block.covers(k, points[cells])]
        if room.any():
            out.append(Level(height, corner, spacing, room))
    return tuple(out)


def _cells(block: Pieces, k: int, corner: np.ndarray, spacing: float, counts: np.ndarray) -> tuple[slice, slice]:
    """Return the cells within the bounds of piece `k`."""
    first = np.maximum(np.ceil((block.low[k, [0, 2]] - corner) / spacing).astype(int), 0)
    last = np.minimum(np.floor((block.high[k, [0, 2]] - corner) / spacing).astype(int) + 1, counts)
    return slice(first[0], max(last[0], first[0])), slice(first[1], max(last[1], first[1]))
