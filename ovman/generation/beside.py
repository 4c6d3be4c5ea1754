"""What may change in a scene beside a scripted change, of instances and places that the tours are foreseen to record. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from itertools import islice

import numpy as np

from ovman import seeds
from ovman.generation import placement
from ovman.generation.placement import ABOVE_SURFACE_M, CLEARANCE_M, FreeFloor
from ovman.generation.protocol import keeps_free
from ovman.generation.roaming import carries, roam
from ovman.generation.script import SHOWN_IN, Kind
from ovman.generation.sight import Sight
from ovman.records.change import Alteration
from ovman.records.geometry import Point
from ovman.records.relation import Relation
from ovman.records.scene import Scene, SceneObject
from ovman.records.sighting import VisitPair
from ovman.records.tour import Tour
from ovman.settings import Others, Settings

SURE_SR = 0.022
"""Steradians from which on an instance is foreseen to be recorded: 500 pixels of the default camera's picture. Of 153 instances
of the benchmark's scenes for which more was foreseen, the untouched tours recorded 151 with 300 pixels or more."""
UNEVEN = frozenset({"Sofa"})
"""Categories whose top is not that of their box: of 62 placements that the simulator refused, 47 met a sofa."""
NEAR_FLOOR_M = 0.9
"""An answer that is farther from where the agent can stand is foreseen to be out of reach."""
PLACES = 40
"""So many places of an instance are looked at."""
SETTLES_M = 0.1
"""What is put somewhere may come to rest so far from there."""


class Beside:
    """What may change in a scene beside a scripted change, and what the tours are foreseen to record of it."""

    def __init__(self, scene: Scene, tours: VisitPair[Tour], terms: Others, constants: Settings) -> None:
        self.scene, self.tours, self.terms, self.keeps_free = scene, tours, terms, keeps_free(scene, tours)
        self._constants = constants
        self._sights = Sight.of(scene, tours.first.waypoints), Sight.of(scene, tours.second.waypoints)
        self.free = [o for o in scene.objects if o.dynamic and not carries(scene, o)]
        self._angle_sr = {
            o.id: tuple(sight.solid_angle(o, _centre(o)) for sight in self._sights) for o in scene.objects if o.dynamic
        }
        number = Counter(o.category for o in scene.objects)
        self.several = frozenset(category for category in number if number[category] > 1)
        self._seen = {name: tuple(angle_sr >= SURE_SR for angle_sr in both) for name, both in self._angle_sr.items()}
        self._places: dict[str, list[Alteration]] = {}
        step_m = constants.mover.step_m
        walks = {o.id: roam(scene, o, self.floor(scene, o), step_m) for o in self.free if o.id in scene.mobile}
        self._walks = {k: Alteration(kind="motion", instance=k, roam=floor) for k, floor in walks.items() if floor is not None}

    def shows_sr(self, item: SceneObject, kind: Kind) -> float:
        """How large an instance is foreseen to look in the tour in which its change shows it, steradians."""
        return self._angle_sr[item.id][("first", "second").index(SHOWN_IN[kind])]

    def floor(self, scene: Scene, item: SceneObject) -> FreeFloor:
        """The free floor for an instance, off the waypoints of the second tour and the place of the agent."""
        return FreeFloor.of(scene, item, self._constants.primitives.step_m, self.keeps_free)

    def serves(self, item: SceneObject, relation: Relation) -> bool:
        """Whether a query for `relation` about `item` is foreseen to be recorded as it must be, and its answer within reach."""
        first, second = self._seen[item.id]
        if relation is Relation.MOVING:
            return second and item.id in self._walks
        if relation is Relation.MOVED:
            return first
        at = item.position.x, item.position.z
        near = float(np.hypot(*np.subtract(self.floor(self.scene, item).nearest(at), at))) <= NEAR_FLOOR_M
        seen = {Relation.APPEARED: second, Relation.STABLE: first and second}.get(relation, first)
        return near and seen

    def recorded_at(self, item: SceneObject, made: Alteration) -> bool:
        """Whether the second tour is foreseen to record the instance where it is put."""
        assert made.placement is not None and made.height_m is not None
        centre = made.placement[0], made.height_m + item.size.y / 2, made.placement[1]
        return self._sights[1].solid_angle(item, centre) >= SURE_SR

    def made(
        self,
        item: SceneObject,
        kind: Kind,
        away: Sequence[Point],
        full: Sequence[SceneObject],
        serves: Callable[[Alteration], bool],
        rng: np.random.Generator,
    ) -> Alteration | None:
        """A change of `item` of that kind, or None.

        away: points on the floor that the change is far from; full: boxes that it meets none of; serves: whether a change of
        `item` may be this one. What is to move on its own sets off from where it stands if it can. Otherwise it is put somewhere
        first, and that displacement is returned.
        """
        first, second = self._seen[item.id]
        gone = Alteration(kind="disable", instance=item.id)
        if not self._away((item.position.x, item.position.z), away):
            return None
        if kind == "motion" and second and item.id in self._walks:
            return self._walks[item.id]
        if kind == "enable":
            return gone if second and serves(gone) else None
        if kind == "disable":
            return gone if first and serves(gone) else None
        if kind == "displace" and not first:
            return None
        on_floor = round(self.scene.floor_y + ABOVE_SURFACE_M, 4)
        apart = [
            made
            for made in self._places_of(item)
            if made.placement is not None and self._away(made.placement, away) and not meets(item, made.placement, full)
            if (kind == "displace" or made.height_m == on_floor) and serves(made)
        ]
        return apart[int(rng.integers(len(apart)))] if apart else None

    def _away(self, point: Point, away: Sequence[Point]) -> bool:
        apart_m = self._constants.candidates.apart_m + SETTLES_M
        return all(float(np.hypot(point[0] - x, point[1] - z)) >= apart_m for x, z in away)

    def _places_of(self, item: SceneObject) -> list[Alteration]:
        """Where the instance may be put; the same whatever it is put there beside."""
        if item.id not in self._places:
            rng = seeds.generator(self._constants.benchmark.seed, "places", self.scene.scene, item.id)
            floor, least_m = self.floor(self.scene, item), self._constants.candidates.delta_min_m + SETTLES_M
            uneven = [o for o in self.scene.objects if o.category in UNEVEN and o.id != item.id]
            everywhere = (
                Alteration(kind="displace", instance=item.id, placement=(spot.x, spot.z), height_m=spot.height_m)
                for spot in placement.spots(self.scene, item, floor, least_m, rng)
                if not meets(item, (spot.x, spot.z), uneven)
            )
            self._places[item.id] = [made for made in islice(everywhere, PLACES) if self.recorded_at(item, made)]
        return self._places[item.id]


def _centre(item: SceneObject) -> tuple[float, float, float]:
    return item.position.x, item.position.y, item.position.z


def meets(item: SceneObject, at: Point, full: Sequence[SceneObject]) -> bool:
    """Whether the instance's box at a point would stand over, under or in one of these, seen from above."""
    half = item.size.x / 2, item.size.z / 2
    return any(
        abs(at[0] - o.position.x) <= half[0] + o.size.x / 2 + CLEARANCE_M
        and abs(at[1] - o.position.z) <= half[1] + o.size.z / 2 + CLEARANCE_M
        for o in full
    )
