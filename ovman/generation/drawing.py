"""What all candidates are drawn with: the tours of a split, scripts of queries, single changes, spawns. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ovman import seeds
from ovman.generation.off_grid import take_off_grid
from ovman.generation.placement import FreeFloor, displacements
from ovman.generation.roaming import roam
from ovman.records.geometry import Point, Spawn
from ovman.records.record import DEGREE_DECIMALS
from ovman.records.scene import Alteration, Scene, SceneObject
from ovman.records.task import Instance, Query, Rejection, Relation, WorldState
from ovman.records.tour import Light, Sensors, Tour
from ovman.records.visit import VisitPair
from ovman.settings import SecondTour, Settings, Split
from ovman.settings.benchmark import Errors
from ovman.task import answer, crowding

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


@dataclass(frozen=True)
class Script:
    """A query about a target of an untouched scene, and what scripted alterations mean for it before any simulation."""

    scene: Scene
    query: Query
    target: str

    def answer(self, first: Sequence[Alteration], second: Sequence[Alteration]) -> Point:
        """Return the answer (Eq. 3) if everything stays where it is put, metres."""
        return answer(self._world(first), self._world(second), self.query, self.target)

    def is_crowded(self, first: Sequence[Alteration], second: Sequence[Alteration], radius_m: float) -> bool:
        """Return whether another instance of the category would be at most `radius_m` from the answer."""
        at = self.answer(first, second)
        return bool(crowding(self._world(first), self._world(second), self.query, self.target, at, radius_m))

    def _world(self, alterations: Sequence[Alteration]) -> WorldState:
        gone = {alteration.instance for alteration in alterations if alteration.kind == "disable"}
        placed = {alteration.instance: alteration.placement for alteration in alterations if alteration.placement is not None}
        return WorldState(
            tuple(
                Instance(o.id, o.category, *placed.get(o.id, o.place))
                for o in self.scene.objects
                if o.category == self.query.category and o.id not in gone
            )
        )


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
    uncrowded: Callable[[Alteration], bool],
    rng: np.random.Generator,
) -> Alteration | Rejection:
    """Draw a displacement of `item` by at least `distance_m` metres onto free floor or a surface, or return why there is none.

    uncrowded: whether the answer stays uncrowded.
    """
    everywhere = list(displacements(scene, item, floor, distance_m, rng))
    found = list(filter(uncrowded, everywhere))
    if not found:
        return Rejection.CROWDED if everywhere else Rejection.NO_PLACEMENT
    return found[int(rng.integers(min(len(found), AMONG)))]


def draw_motion(scene: Scene, item: SceneObject, floor: FreeFloor, step_m: float) -> Alteration | Rejection:
    """Return the motion of `item` from where it stands, in steps of `step_m` metres, or why it cannot move."""
    found = roam(scene, item, floor, step_m)
    return Rejection.CANNOT_MOVE if found is None else Alteration(kind="motion", instance=item.id, roam=found)


Box = tuple[Point, Point, float]
"""A rectangle on the floor: its centre, its half extents, and the distance kept from it; metres."""


def draw_spawn(
    script: Script,
    target: SceneObject,
    first: Sequence[Alteration],
    second: Sequence[Alteration],
    floor: FreeFloor,
    constants: Settings,
    rng: np.random.Generator,
) -> Spawn | None:
    """Draw a spawn for the script's query about `target`; None if there is none.

    It is candidates.spawn_clearance_m away from where the target was and from scripted placements, and farther than
    candidates.spawn_beyond_m from the answer, nu(answer) and the target's box; for MOVING the trials check the latter.
    """
    clearance_m, beyond_m = constants.candidates.spawn_clearance_m, constants.candidates.spawn_beyond_m
    keep_from = [(target.place, clearance_m)]
    boxes: list[Box] = []
    keep_from += [(alteration.placement, clearance_m) for alteration in second if alteration.placement is not None]
    if script.query.relation is not Relation.MOVING:
        at = script.answer(first, second)
        half = target.half if script.query.relation.current else (0.0, 0.0)
        boxes += [(at, half, beyond_m), (floor.nearest(at), (0.0, 0.0), beyond_m)]
    return draw_position_away(floor, keep_from, constants.tour.headings, rng, boxes)


def draw_position_away(
    floor: FreeFloor, keep_from: Sequence[tuple[Point, float]], headings: int, rng: np.random.Generator, boxes: Sequence[Box] = ()
) -> Spawn | None:
    """Draw a reachable position away from the points of `keep_from` and from `boxes`, along one of `headings`, or None.

    Each point and box has its distance in metres: at least that for points, more than that for boxes.
    """
    free = [
        (x, z)
        for x, z in floor.cells
        if all(np.hypot(x - kx, z - kz) >= metres for (kx, kz), metres in keep_from)
        and all(np.hypot(max(abs(x - kx) - hx, 0.0), max(abs(z - kz) - hz, 0.0)) > metres for (kx, kz), (hx, hz), metres in boxes)
    ]
    if not free:
        return None
    x, z = free[int(rng.integers(len(free)))]
    yaw_deg = round(float(360.0 / headings * rng.integers(headings)), DEGREE_DECIMALS)
    return Spawn(x=round(float(x), 4), z=round(float(z), 4), yaw_deg=yaw_deg)
