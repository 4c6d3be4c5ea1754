"""Where an object can be put: free floor, the tops of furniture, and straight lanes for movers.

Pure geometry on the record of a scene, floor plane in metres. It only proposes; the simulator has the last word.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ovman.sim.change import AGENT_RADIUS_M
from ovman.sim.mover import Lane

SURFACES = frozenset(
    (
        "Bed",
        "CoffeeTable",
        "CounterTop",
        "Desk",
        "DiningTable",
        "Dresser",
        "Footstool",
        "Ottoman",
        "SideTable",
        "Sofa",
        "Stool",
        "TVStand",
    )
)
"""Categories whose top carries things."""
LARGEST_ON_SURFACE_M = 0.5
"""Objects wider than this are furniture and stand on the floor."""
ABOVE_SURFACE_M = 0.05
"""Height above a surface from which the simulator looks down for it."""
JITTER_M = 0.1
LONGEST_LANE_M = 4.0


@dataclass(frozen=True)
class FreeFloor:
    """The floor that the agent can reach: an object fits where every lattice point that it would block is reachable."""

    cells: frozenset[tuple[int, int]]
    waypoints: tuple[tuple[float, float], ...]
    step_m: float

    @staticmethod
    def of(scene: Mapping[str, Any], step_m: float) -> FreeFloor:
        cells = frozenset((round(x / step_m), round(z / step_m)) for x, z in scene["reachable"])
        return FreeFloor(cells, tuple((w["x"], w["z"]) for w in scene["waypoints"]), step_m)

    def fits(self, x: float, z: float, half_x: float, half_z: float) -> bool:
        """Whether a rectangle at (x, z) stands on free floor and leaves the waypoints of the tour free."""
        reach = AGENT_RADIUS_M
        if any(
            np.hypot(max(abs(wx - x) - half_x, 0.0), max(abs(wz - z) - half_z, 0.0)) <= reach + self.step_m / 4
            for wx, wz in self.waypoints
        ):
            return False
        low_i, high_i = (int(np.floor((x + s * (half_x + reach)) / self.step_m)) + (s < 0) for s in (-1, 1))
        low_j, high_j = (int(np.floor((z + s * (half_z + reach)) / self.step_m)) + (s < 0) for s in (-1, 1))
        for i in range(low_i, high_i + 1):
            for j in range(low_j, high_j + 1):
                gap = np.hypot(max(abs(i * self.step_m - x) - half_x, 0.0), max(abs(j * self.step_m - z) - half_z, 0.0))
                if gap < reach and (i, j) not in self.cells:
                    return False
        return True


@dataclass(frozen=True)
class Spot:
    """A place for the centre of an object's box, (x, z), and the height from which it is let down."""

    x: float
    z: float
    height_m: float


def _half(item: Mapping[str, Any]) -> tuple[float, float]:
    return item["size"]["x"] / 2, item["size"]["z"] / 2


def _far_enough(item: Mapping[str, Any], x: float, z: float, distance_m: float) -> bool:
    return bool(np.hypot(x - item["position"]["x"], z - item["position"]["z"]) >= distance_m)


def floor_spots(
    scene: Mapping[str, Any], item: Mapping[str, Any], floor: FreeFloor, distance_m: float, rng: np.random.Generator
) -> list[Spot]:
    """Free floor for `item` at least `distance_m` from where it is, one spot a cell, in random order."""
    half_x, half_z = _half(item)
    cells = sorted(floor.cells)
    spots = []
    for k in rng.permutation(len(cells)):
        x, z = (np.array(cells[k]) * floor.step_m + rng.uniform(-JITTER_M, JITTER_M, 2)).round(3)
        if _far_enough(item, x, z, distance_m) and floor.fits(x, z, half_x, half_z):
            spots.append(Spot(float(x), float(z), round(scene["floor_y"] + ABOVE_SURFACE_M, 4)))
    return spots


def surface_spots(scene: Mapping[str, Any], item: Mapping[str, Any], distance_m: float, rng: np.random.Generator) -> list[Spot]:
    """Free places for `item` on furniture at least `distance_m` away: its box clears the boxes of all that stands there."""
    half_x, half_z = _half(item)
    if 2 * max(half_x, half_z) > LARGEST_ON_SURFACE_M:
        return []
    spots = []
    carriers = [o for o in scene["objects"] if o["category"] in SURFACES and o["id"] != item["id"]]
    for k in rng.permutation(len(carriers)):
        carrier = carriers[k]
        carrier_x, carrier_z = _half(carrier)
        if carrier_x <= half_x or carrier_z <= half_z:
            continue
        top = carrier["position"]["y"] + carrier["size"]["y"] / 2
        for _ in range(6):
            x = round(carrier["position"]["x"] + rng.uniform(-1, 1) * (carrier_x - half_x), 3)
            z = round(carrier["position"]["z"] + rng.uniform(-1, 1) * (carrier_z - half_z), 3)
            clear = all(
                _clears(o, x, z, half_x, half_z, top, top + item["size"]["y"])
                for o in scene["objects"]
                if o is not carrier and o is not item
            )
            if clear and _far_enough(item, x, z, distance_m):
                spots.append(Spot(x, z, round(top + ABOVE_SURFACE_M, 4)))
                break
    return spots


def _clears(other: Mapping[str, Any], x: float, z: float, half_x: float, half_z: float, low: float, high: float) -> bool:
    centre, size = other["position"], other["size"]
    return bool(
        abs(centre["x"] - x) > size["x"] / 2 + half_x
        or abs(centre["z"] - z) > size["z"] / 2 + half_z
        or centre["y"] - size["y"] / 2 > high
        or centre["y"] + size["y"] / 2 < low + ABOVE_SURFACE_M / 2
    )


def spots(
    scene: Mapping[str, Any], item: Mapping[str, Any], floor: FreeFloor, distance_m: float, rng: np.random.Generator
) -> list[Spot]:
    """Places for `item`: furniture goes to the floor, small things to furniture or, where there is none, to the floor."""
    return surface_spots(scene, item, distance_m, rng) or floor_spots(scene, item, floor, distance_m, rng)


def lanes(item: Mapping[str, Any], floor: FreeFloor, minimum_m: float) -> Sequence[Lane]:
    """Straight lanes along the lattice, at least `minimum_m` long, on which `item` meets nothing; from nearest to farthest."""
    half_x, half_z = _half(item)
    fitting = {c for c in sorted(floor.cells) if floor.fits(c[0] * floor.step_m, c[1] * floor.step_m, half_x, half_z)}
    longest = int(LONGEST_LANE_M / floor.step_m)
    found = []
    for i, j in sorted(fitting):
        for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            length = 0
            while length < longest and (i + (length + 1) * di, j + (length + 1) * dj) in fitting:
                length += 1
            if length * floor.step_m >= minimum_m:
                s = floor.step_m
                found.append(Lane(i * s, j * s, (i + length * di) * s, (j + length * dj) * s))
    here = item["position"]
    return sorted(
        found, key=lambda lane: (np.hypot(lane.x_0 - here["x"], lane.z_0 - here["z"]), lane.x_0, lane.z_0, lane.x_1, lane.z_1)
    )
