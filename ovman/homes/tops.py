"""The upper faces of an asset on which things can stand, as the engine shapes it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from ovman.homes.catalogue import Asset
from ovman_engine.bodies.forms import extent
from ovman_engine.bodies.static_scene import StaticScene
from ovman_engine.bodies.surfaces import Level, holding
from ovman_engine.plan.house_json import read
from ovman_engine.plan.houseplan import plan_of
from ovman_engine.world.world import World

MARGIN_MM = 12
"""Free floor around a thing on a top"""
LIFT_MM = 2
"""Height of a thing above the face on which it stands, before it settles"""
ROUND = 0.9
"""A round top is used up to this share of its radius: its collision piece is an octagon."""


@dataclass(frozen=True)
class Top:
    """One face. height: above the floor, millimetres; radii: half axes (x, z) of a round one, millimetres."""

    height: int
    level: Level
    radii: tuple[float, float] | None

    def find_spots(self, width: int, height: int, depth: int) -> list[tuple[int, int]]:
        """Return the places (x, z) for a box of this size, millimetres from the middle of the asset at yaw 0."""
        half = ((width / 2 + MARGIN_MM) / 1000, (depth / 2 + MARGIN_MM) / 1000)
        found = self.level.fitting(half, (height + 2 * LIFT_MM) / 1000)
        spots = [(round(1000 * float(x)), round(1000 * float(z))) for x, z in found]
        if self.radii is None:
            return spots
        a, b = (ROUND * radius for radius in self.radii)
        return [(x, z) for x, z in spots if ((abs(x) + width / 2) / a) ** 2 + ((abs(z) + depth / 2) / b) ** 2 <= 1]


@cache
def find_tops(asset: Asset) -> tuple[Top, ...]:
    """Return the faces of an asset that hold things, highest first."""
    floor = [{"x": x, "y": 0, "z": z} for x, z in ((-9, -9), (-9, 9), (9, 9), (9, -9))]
    at = {"x": 0.0, "y": asset.height / 2000, "z": 0.0}
    house = {
        "rooms": [{"id": "room|2", "roomType": "LivingRoom", "floorPolygon": floor}],
        "objects": [{"id": "it", "assetId": asset.id, "position": at, "kinematic": True}],
        "metadata": {"agent": {"position": {"x": 8.0, "y": 0.9, "z": 8.0}}},
    }
    world = World(plan_of(read(house)))
    pieces = [(piece[0], *extent(piece)) for piece in StaticScene.of(world.plan).pieces["it"]]
    out = []
    for level in holding(world, world.bodies["it"]):
        height = level.height - asset.height / 2000
        here = [(kind, half) for kind, middle, half, turn in pieces if abs(middle[1] + (np.abs(turn) @ half)[1] - height) < 0.005]
        round_ = next((half for kind, half in here if kind in ("hull", "cylinder")), None)
        radii = None if round_ is None else (1000 * float(round_[0]), 1000 * float(round_[2]))
        out.append(Top(int(np.ceil(1000 * level.height)), level, radii))
    return tuple(out)
