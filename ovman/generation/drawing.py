"""Draw the parts that candidates of all splits share: tours, single changes, spawns. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ovman import seeds
from ovman.generation.off_grid import take_off_grid
from ovman.generation.placement import FreeFloor, displacements
from ovman.generation.roaming import roam
from ovman.records.geometry import Point, Spawn
from ovman.records.record import DEGREE_DECIMALS, METRE_DECIMALS
from ovman.records.scene import Alteration, Scene, SceneObject
from ovman.records.task import Rejection
from ovman.records.tour import Light, Sensors, Tour
from ovman.records.visit import VisitPair
from ovman.settings import SecondTour, Settings, Split
from ovman.settings.benchmark import Errors

AMONG = 8
"""A displacement is drawn among at most this many places."""
LIGHT_DECIMALS = 3


@dataclass(frozen=True)
class Drawing:
    """The terms under which the candidates of a split are drawn in a scene. tours: of the visits, alike for every candidate."""

    split: Split
    tours: VisitPair[Tour]
    errors: Errors | None = None

    def tours_of(self, name: str, seed: int) -> VisitPair[Tour]:
        """Return the tours of a candidate, with its own light in the second visit and its own errors of sensors in each.

        seed: root of every random number.
        """
        light, terms = None, self.split.light
        if terms is not None:
            rng = seeds.generator(seed, "light", name)
            drawn = {key: round(float(rng.uniform(low, high)), LIGHT_DECIMALS) for key, (low, high) in terms.ranges.items()}
            light = Light(**drawn, materials=seeds.integer(seed, "materials", name) if terms.materials else None)

        def sensors(which: str) -> Sensors | None:
            return None if self.errors is None else Sensors(errors=self.errors, seed=seeds.integer(seed, "sensors", name, which))

        first, second = self.tours.first, self.tours.second
        return VisitPair[Tour](
            first=first.model_copy(update={"sensors": sensors("first")}),
            second=second.model_copy(update={"sensors": sensors("second"), "light": light}),
        )

    @staticmethod
    def of(split: Split, scene: Scene, constants: Settings) -> Drawing:
        """Return how a split draws in a scene. constants: sensors, tour.headings and, off the grid, seed and step."""
        both = tours(scene, constants.tour.headings, split.second_tour)
        if split.off_grid:
            rng = seeds.generator(constants.benchmark.seed, "off_grid", *split.stream, scene.scene)
            first, second = (take_off_grid(tour, scene, constants.primitives.step_m, rng) for tour in (both.first, both.second))
            both = VisitPair[Tour](first=first, second=second)
        errors = None if split.sensors is None else getattr(constants.sensors, split.sensors)
        return Drawing(split, both, errors)

    def id(self, scene: str, relation: str, number: int) -> str:
        """Return the id of a candidate."""
        return "/".join((scene, relation, "-".join((*self.split.stream, f"{number:04d}"))))


def tours(scene: Scene, headings: int, second: SecondTour | None) -> VisitPair[Tour]:
    """Return the tours of both visits: the same twice, or another second tour."""
    first = Tour(waypoints=scene.waypoints, headings=headings)
    if second is None:
        return VisitPair[Tour](first=first, second=first)
    waypoints = scene.other_waypoints if second.other_waypoints else scene.waypoints
    return VisitPair[Tour](first=first, second=Tour(waypoints=waypoints, headings=headings, first_yaw_deg=second.first_yaw_deg))


def places_of_agent(scene: Scene, both: VisitPair[Tour]) -> tuple[Point, ...]:
    """Return the places of the agent, which stay free: waypoints of the second tour, and where the simulator begins.

    The simulator begins near the first waypoint of the scene's own tour.
    """
    again = both.second.waypoints == scene.waypoints
    return both.second.waypoints if again else (*both.second.waypoints, scene.start)


def group_eligible(scene: Scene) -> Mapping[str, list[SceneObject]]:
    """Return the movable instances by category, of categories with at least two instances."""
    by_category: dict[str, list[SceneObject]] = {}
    for item in scene.objects:
        if item.dynamic:
            by_category.setdefault(item.category, []).append(item)
    return {c: items for c, items in sorted(by_category.items()) if len(items) >= 2}


def draw_displacement(
    scene: Scene,
    item: SceneObject,
    floor: FreeFloor,
    distance_m: float,
    rng: np.random.Generator,
) -> Alteration | Rejection:
    """Draw a displacement of `item` by at least `distance_m` metres onto free floor or a surface, or return why there is none."""
    found = list(displacements(scene, item, floor, distance_m, rng))
    return found[int(rng.integers(min(len(found), AMONG)))] if found else Rejection.NO_PLACEMENT


def draw_motion(scene: Scene, item: SceneObject, floor: FreeFloor, step_m: float) -> Alteration | Rejection:
    """Return the motion of `item` from where it stands, in steps of `step_m` metres, or why it cannot move."""
    found = roam(scene, item, floor, step_m)
    return Rejection.CANNOT_MOVE if found is None else Alteration(kind="motion", instance=item.id, roam=found)


def draw_spawn(
    target: SceneObject, second: Sequence[Alteration], floor: FreeFloor, constants: Settings, rng: np.random.Generator
) -> Spawn | None:
    """Draw a spawn candidates.spawn_clearance_m away from where the target was and from placements; None if there is none.

    second: the alterations of the second visit.
    """
    placements = [made.placement for made in second if made.placement is not None]
    clearance_m = constants.candidates.spawn_clearance_m
    free = [cell for cell in floor.cells if all(math.dist(cell, at) >= clearance_m for at in (target.place, *placements))]
    return pick_spawn(free, constants.tour.headings, rng)


def pick_spawn(free: Sequence[Point] | np.ndarray, headings: int, rng: np.random.Generator) -> Spawn | None:
    """Pick one of the free cells (x, z), metres, and one of `headings` yaws; None if no cell is free."""
    if not len(free):
        return None
    x, z = free[int(rng.integers(len(free)))]
    yaw_deg = round(float(360.0 / headings * rng.integers(headings)), DEGREE_DECIMALS)
    return Spawn(x=round(float(x), METRE_DECIMALS), z=round(float(z), METRE_DECIMALS), yaw_deg=yaw_deg)
