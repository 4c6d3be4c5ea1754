"""Distractors: instances of other categories that change between the visits, similar in size to the scripted one. Pure.

As many of each kind of change are drawn as the split asks for, of instances and places that the tours are expected to record.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

import numpy as np

from ovman import seeds
from ovman.generation import placement
from ovman.generation.drawing import KIND_OF, SHOWN_IN, Kind, Script, places_of_agent
from ovman.generation.placement import ABOVE_SURFACE_M, CLEARANCE_M, FreeFloor
from ovman.generation.roaming import carries, goes_m, roam, side
from ovman.generation.sight import Sight
from ovman.records.geometry import Point
from ovman.records.scene import Alteration, Scene, SceneObject
from ovman.records.task import Query, Rejection, Relation
from ovman.records.tour import Tour
from ovman.records.visit import VisitPair
from ovman.settings import Others, Settings
from ovman.sim.world import spawn_streams

SURE_SR = 0.022
"""Solid angle from which an instance is expected to be recorded, steradians: 500 pixels of the default camera's picture. Of 153
instances of the benchmark's scenes above it, the untouched tours recorded 151 with 300 pixels or more."""
UNEVEN = frozenset({"Sofa"})
"""Categories whose top is below that of their box: of 62 placements that the simulator refused, 47 met a sofa."""
NEAR_FLOOR_M = 0.9
"""An answer farther than this from the nearest cell is expected to be out of reach."""
PLACES = 40
"""Number of places that are considered per instance."""
SETTLES_M = 0.1
"""A placed instance may come to rest this far from its placement."""
KINDS: tuple[Kind, ...] = ("displace", "enable", "disable")
"""Kinds of distractors for any scripted change; movers are distractors of a scripted mover only."""
PLACED = frozenset((Relation.MOVED, Relation.FORMER, Relation.APPEARED, Relation.REMOVED))
"""Relations whose answer is the place of the scripted change, from the start of the second visit."""


class Surroundings:
    """The possible distractors of a scene, and what the tours are expected to record of them."""

    def __init__(self, scene: Scene, tours: VisitPair[Tour], terms: Others, constants: Settings) -> None:
        self.scene, self.tours, self.terms, self.keeps_free = scene, tours, terms, places_of_agent(scene, tours)
        self._constants = constants
        self._sights = Sight.of(scene, tours.first.waypoints), Sight.of(scene, tours.second.waypoints)
        self.free = [o for o in scene.objects if o.dynamic and not carries(scene, o)]
        self._angle_sr = {
            o.id: tuple(sight.solid_angle(o, (o.place[0], o.position.y, o.place[1])) for sight in self._sights)
            for o in scene.objects
            if o.dynamic
        }
        number = Counter(o.category for o in scene.objects)
        self.several = frozenset(category for category in number if number[category] > 1)
        self._seen = {name: tuple(angle_sr >= SURE_SR for angle_sr in both) for name, both in self._angle_sr.items()}
        self._places: dict[str, list[Alteration]] = {}
        step_m = constants.mover.step_m
        walks = {o.id: roam(scene, o, self.floor(scene, o), step_m) for o in self.free if o.id in scene.mobile}
        self._walks = {k: Alteration(kind="motion", instance=k, roam=floor) for k, floor in walks.items() if floor is not None}

    def shows_sr(self, item: SceneObject, kind: Kind) -> float:
        """Return how large an instance is expected to look in the tour in which its change shows it, steradians."""
        return self._angle_sr[item.id][("first", "second").index(SHOWN_IN[kind])]

    def floor(self, scene: Scene, item: SceneObject) -> FreeFloor:
        """Return the free floor for an instance, off the places of the agent."""
        return FreeFloor.of(scene, item, self._constants.primitives.step_m, self.keeps_free)

    def serves(self, item: SceneObject, relation: Relation) -> bool:
        """Return whether a query about `item` is expected to be recorded as required, with its answer within reach."""
        first, second = self._seen[item.id]
        if relation is Relation.MOVING:
            return second and item.id in self._walks
        if relation is Relation.MOVED:
            return first
        near = float(np.hypot(*np.subtract(self.floor(self.scene, item).nearest(item.place), item.place))) <= NEAR_FLOOR_M
        seen = {Relation.APPEARED: second, Relation.STABLE: first and second}.get(relation, first)
        return near and seen

    def is_recorded_at(self, item: SceneObject, made: Alteration) -> bool:
        """Return whether the second tour is expected to record the instance where it is put."""
        assert made.placement is not None and made.height_m is not None
        centre = made.placement[0], made.height_m + item.size.y / 2, made.placement[1]
        return self._sights[1].solid_angle(item, centre) >= SURE_SR

    def make_change(
        self,
        item: SceneObject,
        kind: Kind,
        away: Sequence[Point],
        full: Sequence[SceneObject],
        serves: Callable[[Alteration], bool],
        rng: np.random.Generator,
    ) -> Alteration | None:
        """Return a change of `item` of that kind, or None.

        away: points on the floor that the change keeps away from; full: boxes that it must not meet; serves: whether a change of
        `item` is acceptable. A mover sets off from where it stands if it can. Otherwise it is displaced first, and that
        displacement is returned.
        """
        first, second = self._seen[item.id]
        gone = Alteration(kind="disable", instance=item.id)
        if not self._away(item.place, away):
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
            if made.placement is not None and self._away(made.placement, away) and not is_over_any(item, made.placement, full)
            if (kind == "displace" or made.height_m == on_floor) and serves(made)
        ]
        return apart[int(rng.integers(len(apart)))] if apart else None

    def _away(self, point: Point, away: Sequence[Point]) -> bool:
        apart_m = self._constants.candidates.apart_m + SETTLES_M
        return all(float(np.hypot(point[0] - x, point[1] - z)) >= apart_m for x, z in away)

    def _places_of(self, item: SceneObject) -> list[Alteration]:
        """Return where the instance may be put, independent of the scripted change."""
        if item.id not in self._places:
            rng = seeds.generator(self._constants.benchmark.seed, "places", self.scene.scene, item.id)
            floor, least_m = self.floor(self.scene, item), self._constants.candidates.delta_min_m + SETTLES_M
            uneven = [o for o in self.scene.objects if o.category in UNEVEN and o.id != item.id]
            everywhere = (
                made
                for made in placement.displacements(self.scene, item, floor, least_m, rng)
                if made.placement is not None and not is_over_any(item, made.placement, uneven)
            )
            self._places[item.id] = [made for made in islice(everywhere, PLACES) if self.is_recorded_at(item, made)]
        return self._places[item.id]


def is_over_any(item: SceneObject, at: Point, full: Sequence[SceneObject]) -> bool:
    """Return whether the instance's box at a point would overlap one of these, seen from above."""
    return any(all(abs(at[k] - o.place[k]) <= item.half[k] + o.half[k] + CLEARANCE_M for k in (0, 1)) for o in full)


@dataclass(frozen=True)
class Altered:
    """All alterations of both visits, the scripted ones first, and the categories of the distractors by their ids."""

    first: tuple[Alteration, ...]
    second: tuple[Alteration, ...]
    categories: Mapping[str, str]


def draw_distractors(
    surroundings: Surroundings,
    changed: SceneObject,
    relation: Relation,
    script: Script,
    first: tuple[Alteration, ...],
    second: tuple[Alteration, ...],
    constants: Settings,
    rng: np.random.Generator,
    walk_rng: np.random.Generator,
) -> Altered | Rejection:
    """Draw the distractors of a pair of tours in which `changed` changes for the script's query; NO_OTHERS if too few.

    first, second: the scripted alterations; walk_rng: of the movers of the second tour. The number of like changes that look
    larger than the scripted one is drawn, so that the largest or the smallest change is worth no more than a guess.
    Categories with several instances go first, since the queried category has several. Like changes are as uncrowded as the
    answer (candidates.crowding_m). Distractors are farther than candidates.apart_m from the scripted change and from the answer.
    """
    terms = surroundings.terms
    own, alike = KIND_OF[relation], getattr(terms.alike, relation.value)
    wanted = int(rng.integers(terms.count[0], terms.count[1] + 1))
    put = [(changed, alteration) for alteration in second if alteration.placement is not None]
    away = [changed.place, script.answer(first, second)]
    away += [alteration.placement for _, alteration in put if alteration.placement is not None]
    full = [changed, *(_put(item, alteration) for item, alteration in put)]
    pool = [o for o in surroundings.free if o.category != script.query.category and _comparable(o, changed, terms.size_ratio)]
    pool = [pool[k] for k in rng.permutation(len(pool))]
    shows_sr = surroundings.shows_sr(changed, own)
    larger = [o for o in pool if surroundings.shows_sr(o, own) > shows_sr]
    smaller = [o for o in pool if surroundings.shows_sr(o, own) <= shows_sr]
    above = int(rng.integers(alike + 1))
    there, moving, categories = surroundings.scene, [changed] if relation is Relation.MOVING else [], dict[str, str]()
    begins: dict[str, Alteration] = {}
    likes: list[Script] = []

    def like(item: SceneObject) -> Script:
        return Script(surroundings.scene, Query(item.category, relation), item.id)

    def uncrowded(item: SceneObject, kind: Kind, made: Alteration) -> bool:
        """Return whether every like change stays as uncrowded as the answer must be."""
        if relation not in PLACED:
            return True
        visits = ((*first, made), second) if kind == "enable" else (first, (*second, made))
        apart_m = constants.candidates.crowding_m
        return not any(one.is_crowded(*visits, apart_m) for one in (*likes, *([like(item)] if kind == own else [])))

    for number in range(wanted):
        turns: list[Kind] = [own] if number < alike else [KINDS[k] for k in rng.permutation(len(KINDS))]
        ranked = pool if number >= alike else larger if number < above else smaller
        ranked = sorted(ranked, key=lambda o: o.category not in surroundings.several)
        options = ((kind, o) for kind in turns for o in ranked if o.id not in categories and not _touch(o, full))
        chosen = next(
            (
                (kind, o, made)
                for kind, o in options
                if (made := surroundings.make_change(o, kind, away, full, partial(uncrowded, o, kind), rng)) is not None
            ),
            None,
        )
        if chosen is None:
            break
        kind, item, made = chosen
        categories[item.id] = item.category
        full.append(item)
        likes += [like(item)] if kind == own else []
        if kind == "motion":
            begins[item.id] = made
            moving.append(
                item if made.placement is None else _put(item, made).moved_to(y=surroundings.scene.floor_y + item.size.y / 2)
            )
        elif kind == "enable":
            first = (*first, made)
        else:
            second = (*second, made)
        if made.placement is not None and made.height_m is not None:
            full.append(_put(item, made))
            there = placement.put(there, item, made.placement, made.height_m)
    if len(categories) < max(alike, terms.count[0]):
        return Rejection.NO_OTHERS
    if moving:
        walks = _walks(surroundings, there, moving, begins, constants, walk_rng)
        if walks is None:
            return Rejection.NO_OTHERS
        second = (*walks, *(one for one in second if one.kind != "motion"))
    return Altered(first, second, categories)


def _walks(
    surroundings: Surroundings,
    there: Scene,
    moving: Sequence[SceneObject],
    begins: Mapping[str, Alteration],
    constants: Settings,
    walk_rng: np.random.Generator,
) -> tuple[Alteration, ...] | None:
    """Return the motions of several instances in a scene, each on its own floor; None if one goes less than mover_min_m.

    begins: the displacements of instances that are displaced first; walk_rng: of the movers, as `World` has it.
    """
    walks, steps = [], len(surroundings.tours.second.waypoints) * surroundings.tours.second.headings
    for item, stream in zip(moving, spawn_streams(walk_rng, len(moving)), strict=True):
        floor = roam(there, item, surroundings.floor(there, item), constants.mover.step_m)
        for other in moving:
            if other is not item and floor is not None:
                floor = side(floor, other.place, float(np.hypot(item.size.x, item.size.z)) / 2 + CLEARANCE_M)
        if floor is None or goes_m(floor, constants.mover, stream, steps) < constants.candidates.mover_min_m:
            return None
        begin = begins.get(item.id)
        placement, height_m = (None, None) if begin is None else (begin.placement, begin.height_m)
        walks.append(Alteration(kind="motion", instance=item.id, placement=placement, height_m=height_m, roam=floor))
    return tuple(walks)


def _put(item: SceneObject, made: Alteration) -> SceneObject:
    assert made.placement is not None
    return item.moved_to(x=made.placement[0], z=made.placement[1])


def _comparable(one: SceneObject, other: SceneObject, ratio: float) -> bool:
    """Return whether the volumes of two boxes are within a ratio of each other."""
    volumes = [max(item.size.x * item.size.y * item.size.z, 1e-9) for item in (one, other)]
    return max(volumes) <= ratio * min(volumes)


def _touch(item: SceneObject, full: Sequence[SceneObject]) -> bool:
    """Return whether an instance is on, under or in one of these, so that a change of one would change the other."""
    return any(item.id == o.id or o.id in item.parents or item.id in o.parents for o in full) or is_over_any(
        item, item.place, full
    )
