"""Where an object can be put: free floor and the tops of furniture.

Pure geometry on the record of a scene, floor plane in metres. It proposes; the simulator decides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.records.geometry import Point
from ovman.records.scene import Alteration, Scene, SceneObject
from ovman.sim.world import AGENT_RADIUS_M

SURFACES = frozenset(
    (
        *("Bed", "CoffeeTable", "CounterTop", "Desk", "DiningTable", "Dresser"),
        *("Footstool", "Ottoman", "SideTable", "Sofa", "Stool", "TVStand"),
    )
)
"""Categories whose top carries objects."""
SLABS = frozenset(("CounterTop",))
"""Categories whose recorded box covers their top alone; the part below reaches to the floor."""
LARGEST_ON_SURFACE_M = 0.5
"""Objects wider than this are furniture and stand on the floor."""
ABOVE_SURFACE_M = 0.05
"""Height above a surface from which the simulator looks down for it."""
CLEARANCE_M = 0.02
"""Gap between a placed object and its neighbours."""
FLUSH_M = 0.02
"""An object that ends at most this far below a surface is sunk into it, such as a sink or a burner."""
JITTER_M = 0.1
"""Largest distance of a spot from its cell, along x and along z, metres."""


@dataclass(frozen=True)
class FreeFloor:
    """The floor of a scene for one object: its box meets no other box, stays in the room and leaves the waypoints free."""

    cells: np.ndarray
    """(K, 2) metres: the positions that the agent can reach, sorted."""
    waypoints: np.ndarray
    """(W, 2) metres."""
    boxes: np.ndarray
    """(B, 4) metres: centre x, z and half extents of every other box at the object's height."""
    half: np.ndarray
    """(2,) metres: half extents of the object's own box."""
    step_m: float
    find_rooms: Callable[[np.ndarray], np.ndarray]
    """`Scene.find_rooms`: walls have no boxes, so a box has to lie in one room."""
    is_whole: bool
    """Whether all floor of the rooms is known, also where the agent does not fit."""

    @staticmethod
    def of(scene: Scene, item: SceneObject, step_m: float, waypoints: Sequence[Point]) -> FreeFloor:
        """Build the free floor of a scene for `item`. step_m: spacing of the grid, metres; waypoints: to leave free."""
        top = scene.floor_y + item.size.y
        boxes = [
            (*o.place, *o.half)
            for o in scene.objects
            if o.id != item.id and o.category != "Floor" and (o.category in SLABS or o.bottom_y < top)
        ]
        cells = np.array(sorted(scene.reachable))
        return FreeFloor(
            cells,
            np.array(waypoints),
            np.array(boxes).reshape(-1, 4),
            np.array(item.half),
            step_m,
            scene.find_rooms,
            scene.rooms is not None,
        )

    def apart(self, points: np.ndarray) -> np.ndarray:
        """Return (M, B) metres between the object's box at each point and every other box, negative if they overlap.

        Distances are along the axis that separates the boxes best.
        """
        gap = np.abs(points[:, None] - self.boxes[None, :, :2]) - self.half - self.boxes[None, :, 2:]
        parted: np.ndarray = gap.max(axis=2)
        return parted

    def off_waypoints(self, points: np.ndarray) -> np.ndarray:
        """Return (M,) bool: whether the object's box at each point leaves the waypoints free."""
        from_waypoint = np.hypot(*np.maximum(np.abs(points[:, None] - self.waypoints) - self.half, 0.0).transpose(2, 0, 1))
        off: np.ndarray = (from_waypoint > AGENT_RADIUS_M + self.step_m / 4).all(axis=1)
        return off

    def fits(self, points: np.ndarray) -> np.ndarray:
        """Return (M,) bool: whether the object's box can stand with its centre at each of `points` (M, 2), metres."""
        points = np.asarray(points, float).reshape(-1, 2)
        clear = (self.apart(points) > CLEARANCE_M).all(axis=1) & self.off_waypoints(points)
        corners = points[:, None] + self.half * np.array([(x, z) for x in (-1, 1) for z in (-1, 1)])
        inside = np.zeros((len(points), 4), bool)
        for k in np.flatnonzero(clear):
            to_cell = np.hypot(*(corners[k][:, None] - self.cells).transpose(2, 0, 1))
            inside[k] = to_cell.min(axis=1) <= AGENT_RADIUS_M + self.step_m / 2
        in_room = self.find_rooms(corners) == self.find_rooms(points)[:, None]
        fitting: np.ndarray = clear & (inside & in_room).all(axis=1)
        return fitting


@dataclass(frozen=True)
class Spot:
    """A place for the centre of an object's box, (x, z), and the height from which it is lowered."""

    x: float
    z: float
    height_m: float


def floor_spots(scene: Scene, item: SceneObject, floor: FreeFloor, distance_m: float, rng: np.random.Generator) -> list[Spot]:
    """Return free floor for `item` at least `distance_m` from its place, at most one spot per cell, in random order."""
    points = (floor.cells + rng.uniform(-JITTER_M, JITTER_M, floor.cells.shape)).round(3)[rng.permutation(len(floor.cells))]
    away = np.hypot(points[:, 0] - item.position.x, points[:, 1] - item.position.z) >= distance_m
    height_m = round(scene.floor_y + ABOVE_SURFACE_M, 4)
    return [Spot(float(x), float(z), height_m) for x, z in points[away & floor.fits(points)]]


def surface_spots(scene: Scene, item: SceneObject, distance_m: float, rng: np.random.Generator) -> list[Spot]:
    """Return free places for `item` on furniture at least `distance_m` away; its box clears the boxes of all that stand there."""
    half_x, half_z = item.half
    if 2 * max(half_x, half_z) > LARGEST_ON_SURFACE_M:
        return []
    spots = []
    carriers = [o for o in scene.objects if o.category in SURFACES and o.id != item.id]
    for k in rng.permutation(len(carriers)):
        carrier = carriers[k]
        carrier_x, carrier_z = carrier.half
        if carrier_x <= half_x or carrier_z <= half_z:
            continue
        top = carrier.position.y + carrier.size.y / 2
        for _ in range(6):
            x = round(carrier.position.x + rng.uniform(-1, 1) * (carrier_x - half_x), 3)
            z = round(carrier.position.z + rng.uniform(-1, 1) * (carrier_z - half_z), 3)
            clear = all(
                _clears(o, x, z, half_x, half_z, top, top + item.size.y)
                for o in scene.objects
                if o is not carrier and o is not item
            )
            if clear and np.hypot(x - item.position.x, z - item.position.z) >= distance_m:
                spots.append(Spot(x, z, round(top + ABOVE_SURFACE_M, 4)))
                break
    return spots


def _clears(other: SceneObject, x: float, z: float, half_x: float, half_z: float, low: float, high: float) -> bool:
    centre, size = other.position, other.size
    return bool(
        abs(centre.x - x) > size.x / 2 + half_x
        or abs(centre.z - z) > size.z / 2 + half_z
        or other.bottom_y > high
        or centre.y + size.y / 2 < low - FLUSH_M
    )


def put(scene: Scene, item: SceneObject, placement: Point, height_m: float) -> Scene:
    """Return the scene with the instance where it is put."""
    x, z = placement
    there = item.moved_to(x=x, y=height_m + item.size.y / 2, z=z)
    return scene.model_copy(update={"objects": tuple(there if o.id == item.id else o for o in scene.objects)})


def displacements(
    scene: Scene, item: SceneObject, floor: FreeFloor, distance_m: float, rng: np.random.Generator
) -> Iterator[Alteration]:
    """Yield displacements of `item`: furniture goes to the floor; small objects go to furniture, or to the floor if none fits."""
    for spot in surface_spots(scene, item, distance_m, rng) or floor_spots(scene, item, floor, distance_m, rng):
        yield Alteration(kind="displace", instance=item.id, placement=(spot.x, spot.z), height_m=spot.height_m)
