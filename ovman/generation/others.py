"""What else changes between the visits: instances of other categories, of the size of the scripted one, away from it. Pure.

Of each kind of change as many are drawn as the split asks for, of instances and places that the tours are foreseen to record.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from types import MappingProxyType
from typing import Literal

import numpy as np

from ovman.generation import placement
from ovman.generation.placement import ABOVE_SURFACE_M, CLEARANCE_M, FreeFloor
from ovman.generation.protocol import keeps_free
from ovman.generation.roaming import carries, goes_m, roam, side
from ovman.generation.script import Script
from ovman.generation.sight import Sight
from ovman.models.change import Alteration
from ovman.models.geometry import Point
from ovman.models.rejection import Rejection
from ovman.models.relation import Relation
from ovman.models.scene import Scene, SceneObject
from ovman.models.settings import Others, Settings
from ovman.models.sighting import VisitPair
from ovman.models.tour import Tour
from ovman.sim.mover import streams
from ovman.workflow import seeds

Kind = Literal["displace", "enable", "disable", "motion"]
"""As `Change.kind`: "enable" is gone in the first visit alone."""
KINDS: tuple[Kind, ...] = ("displace", "enable", "disable")
"""What may change beside any scripted change; instances move on their own beside such a one only."""
KIND_OF: Mapping[Relation, Kind] = {
    Relation.MOVED: "displace",
    Relation.FORMER: "displace",
    Relation.STABLE: "displace",
    Relation.MOVING: "motion",
    Relation.APPEARED: "enable",
    Relation.REMOVED: "disable",
}
"""The kind of the scripted change of each relation."""
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
NOBODY: Mapping[str, str] = MappingProxyType({})
"""No other changes."""


@dataclass(frozen=True)
class Found:
    """All alterations of both visits, the scripted ones first, and the categories of the other instances by their ids."""

    first: tuple[Alteration, ...]
    second: tuple[Alteration, ...]
    categories: Mapping[str, str]


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
        """How large an instance is foreseen to look in the tour from which its change takes it, or to which it brings it."""
        return self._angle_sr[item.id][kind in ("enable", "motion")]

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
        self, item: SceneObject, kind: Kind, away: Sequence[Point], full: Sequence[SceneObject], rng: np.random.Generator
    ) -> Alteration | None:
        """A change of `item` of that kind; None where there is none. away: points to keep away from; full: boxes to leave alone.

        What is to move on its own sets off from where it stands if it can. Otherwise it is put somewhere first, and what is given
        back is that displacement.
        """
        first, second = self._seen[item.id]
        if not self._away((item.position.x, item.position.z), away):
            return None
        if kind == "motion" and second and item.id in self._walks:
            return self._walks[item.id]
        if kind == "enable":
            return _gone(item) if second else None
        if kind == "disable":
            return _gone(item) if first else None
        if kind == "displace" and not first:
            return None
        on_floor = round(self.scene.floor_y + ABOVE_SURFACE_M, 4)
        apart = [
            made
            for made in self._places_of(item)
            if made.placement is not None and self._away(made.placement, away) and not _meets(item, made.placement, full)
            if kind == "displace" or made.height_m == on_floor
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
                if not _meets(item, (spot.x, spot.z), uneven)
            )
            self._places[item.id] = [made for made in islice(everywhere, PLACES) if self.recorded_at(item, made)]
        return self._places[item.id]


def draw(
    beside: Beside,
    changed: SceneObject,
    relation: Relation,
    script: Script,
    first: tuple[Alteration, ...],
    second: tuple[Alteration, ...],
    constants: Settings,
    rng: np.random.Generator,
    walk_rng: np.random.Generator,
) -> Found | Rejection:
    """What else changes in a pair of tours in which `changed` changes for the script's query; NO_OTHERS where it is too little.

    first, second: the scripted alterations; walk_rng: of the movers of the second tour. Of those that change alike, as many look
    larger than the scripted one as is drawn: who answers with the largest change, or the smallest, is no better off than who
    answers with any. Likewise categories with several instances go first: of the queried one there are several. The others are
    farther than candidates.apart_m from where the scripted change is made and from the answer.
    """
    terms = beside.terms
    own, alike = KIND_OF[relation], getattr(terms.alike, relation.value)
    wanted = int(rng.integers(terms.count[0], terms.count[1] + 1))
    by_id = {o.id: o for o in beside.scene.objects}
    put = [(changed, alteration) for alteration in second if alteration.placement is not None]
    away = [(changed.position.x, changed.position.z), script.answer(first, second)]
    away += [alteration.placement for _, alteration in put if alteration.placement is not None]
    full = [changed, *(_put(item, alteration) for item, alteration in put)]
    pool = [o for o in beside.free if o.category != script.query.category and _comparable(o, changed, terms.size_ratio)]
    pool = [pool[k] for k in rng.permutation(len(pool))]
    shows_sr = beside.shows_sr(changed, own)
    larger = [o for o in pool if beside.shows_sr(o, own) > shows_sr]
    smaller = [o for o in pool if beside.shows_sr(o, own) <= shows_sr]
    above = int(rng.integers(alike + 1))
    there, moving, categories = beside.scene, [changed] if relation is Relation.MOVING else [], dict[str, str]()
    begins: dict[str, Alteration] = {}
    for number in range(wanted):
        turns: list[Kind] = [own] if number < alike else [KINDS[k] for k in rng.permutation(len(KINDS))]
        ranked = pool if number >= alike else larger if number < above else smaller
        ranked = sorted(ranked, key=lambda o: o.category not in beside.several)
        options = ((kind, o) for kind in turns for o in ranked if o.id not in categories and not _touch(o, full))
        chosen = next(((kind, o, made) for kind, o in options if (made := beside.made(o, kind, away, full, rng))), None)
        if chosen is None:
            break
        kind, item, made = chosen
        categories[item.id] = item.category
        full.append(item)
        if kind == "motion":
            begins[item.id] = made
            moving.append(item if made.placement is None else _standing(_put(item, made), beside.scene.floor_y))
        elif kind == "enable":
            first = (*first, made)
        else:
            second = (*second, made)
        if made.placement is not None and made.height_m is not None:
            full.append(_put(item, made))
            there = placement.put(there, by_id[item.id], made.placement, made.height_m)
    if len(categories) < max(alike, terms.count[0]):
        return Rejection.NO_OTHERS
    if moving:
        walks = _walks(beside, there, moving, begins, constants, walk_rng)
        if walks is None:
            return Rejection.NO_OTHERS
        second = (*walks, *(one for one in second if one.kind != "motion"))
    return Found(first, second, categories)


def _walks(
    beside: Beside,
    there: Scene,
    moving: Sequence[SceneObject],
    begins: Mapping[str, Alteration],
    constants: Settings,
    walk_rng: np.random.Generator,
) -> tuple[Alteration, ...] | None:
    """The motions of several instances in a scene, each on a floor of its own; None where one of them comes less than
    candidates.mover_min_m far.

    begins: where those begin that are put somewhere first; walk_rng: of the movers, as a world has it.
    """
    walks, steps = [], len(beside.tours.second.waypoints) * beside.tours.second.headings
    for item, stream in zip(moving, streams(walk_rng, len(moving)), strict=True):
        floor = roam(there, item, beside.floor(there, item), constants.mover.step_m)
        for other in moving:
            if other is not item and floor is not None:
                floor = side(floor, (other.position.x, other.position.z), _half_m(item) + CLEARANCE_M)
        if floor is None or goes_m(floor, constants.mover, stream, steps) < constants.candidates.mover_min_m:
            return None
        begin = begins.get(item.id)
        placement, height_m = (None, None) if begin is None else (begin.placement, begin.height_m)
        walks.append(Alteration(kind="motion", instance=item.id, placement=placement, height_m=height_m, roam=floor))
    return tuple(walks)


def _centre(item: SceneObject) -> tuple[float, float, float]:
    return item.position.x, item.position.y, item.position.z


def _gone(item: SceneObject) -> Alteration:
    return Alteration(kind="disable", instance=item.id)


def _put(item: SceneObject, made: Alteration) -> SceneObject:
    assert made.placement is not None
    x, z = made.placement
    return item.model_copy(update={"position": item.position.model_copy(update={"x": x, "z": z})})


def _comparable(one: SceneObject, other: SceneObject, ratio: float) -> bool:
    """Whether the volumes of two boxes are within a ratio of each other."""
    volumes = [max(item.size.x * item.size.y * item.size.z, 1e-9) for item in (one, other)]
    return max(volumes) <= ratio * min(volumes)


def _standing(item: SceneObject, floor_y: float) -> SceneObject:
    """The instance on the floor where it is, metres."""
    return item.model_copy(update={"position": item.position.model_copy(update={"y": floor_y + item.size.y / 2})})


def _half_m(item: SceneObject) -> float:
    """Half the diagonal of an instance's box, seen from above."""
    return float(np.hypot(item.size.x, item.size.z)) / 2


def _meets(item: SceneObject, at: Point, full: Sequence[SceneObject]) -> bool:
    """Whether the instance's box at a point would stand over, under or in one of these, seen from above."""
    half = item.size.x / 2, item.size.z / 2
    return any(
        abs(at[0] - o.position.x) <= half[0] + o.size.x / 2 + CLEARANCE_M
        and abs(at[1] - o.position.z) <= half[1] + o.size.z / 2 + CLEARANCE_M
        for o in full
    )


def _touch(item: SceneObject, full: Sequence[SceneObject]) -> bool:
    """Whether an instance is on, under or in one of these: a change of the one would change the other."""
    return any(item.id == o.id or o.id in item.parents or item.id in o.parents for o in full) or _meets(
        item, (item.position.x, item.position.z), full
    )
