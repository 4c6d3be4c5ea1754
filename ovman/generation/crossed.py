"""World pairs: several instances of several categories change at once, and every query that the changes define is asked. Pure.

A pair is crossed if every relation is asked about at least two nouns, and every noun under at least two relations. Then an agent
that ignores the noun, or the relation, gives one answer to several queries of which at most one is right (docs/crossed.md).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from typing import Literal, get_args

import numpy as np

from ovman import seeds
from ovman.generation.drawing import Drawing, pick_spawn, places_of_agent
from ovman.generation.placement import ABOVE_SURFACE_M, FreeFloor, displacements
from ovman.generation.roaming import carries, cut, roam, side
from ovman.generation.sight import Sight
from ovman.homes.catalogue import looks_different
from ovman.records.geometry import Point, Spawn
from ovman.records.scene import Alteration, Roam, Scene, SceneObject
from ovman.records.task import Query, Relation
from ovman.records.trial import Candidate
from ovman.settings import Settings
from ovman.sim.world import AGENT_RADIUS_M, Mover, spawn_streams, walk

SURE_SR = 0.022
"""Solid angle from which an instance is expected to be recorded, steradians: 500 pixels of the default camera's picture. Of 153
instances of the floor plans above it, the untouched tours recorded 151 with 300 pixels or more."""
MAYBE_SR = 0.009
"""Solid angle up to which an instance is expected not to be recorded: 200 pixels."""
NEAR_FLOOR_M = 0.9
"""An answer farther than this from the nearest cell is expected to be out of reach."""
SEARCHES, STEPS = 9, 250
"""Number of searches for a script per scene, and of steps of each; the best script that can be carried out is taken."""
BEGINNINGS = 20
"""Number of beginnings of a search, of which the best one is taken."""
IDENTITY = 0.5
"""Worth of a noun of which one instance moves, another vanishes and a third appears: looks alone tell which place is which."""
MOVERS = 3
"""Most movers of a script. With three, two queries about movers are left if one of them fails later."""
WALKS = 6
"""Number of walks of its movers that a script is tried with."""
HOPE = 0.1
"""Worth of a query that the crossing would drop: it may become one of two."""
PLACES = 8
"""Number of places that are considered for an instance of a floor plan."""
MARGIN_M = 0.3
"""The cell next to an answer is nearer to it than to every rival by this much: an agent that stops near that cell succeeds."""
SETTLES_M = 0.1
"""A placed instance may come to rest this far from its placement."""
RESERVE = 4
"""Queries that are drawn in excess of those that a pair may have: some fail later, and a query may need another one."""
FEWEST = 2
"""Least number of nouns per relation, of relations per noun, and of instances of a noun in the visit that a relation reads."""
WORTHS: Mapping[Relation, float] = {Relation.MOVING: 4.5, Relation.STABLE: 3.2}
"""Worth of a relation where it is not 1: few scripts can serve these."""
FURTHER = 0.25
"""Worth of each further query of a relation that two nouns are asked about, in units of the first two."""


def rate(queries: Iterable[Query]) -> float:
    """Return the worth of crossed queries: of their relations first, and of their number second."""
    numbers = Counter(query.relation for query in queries)
    return sum(WORTHS.get(relation, 1.0) * (1.0 + FURTHER * (number - FEWEST)) for relation, number in numbers.items())


def prune(queries: Iterable[Query]) -> frozenset[Query]:
    """Return the largest crossed subset: each relation with two nouns or more, each noun with two relations or more."""
    kept = frozenset(queries)
    while True:
        relations, nouns = Counter(query.relation for query in kept), Counter(query.category for query in kept)
        left = frozenset(q for q in kept if relations[q.relation] >= FEWEST and nouns[q.category] >= FEWEST)
        if left == kept:
            return kept
        kept = left


def limit(queries: Iterable[Query], most: int) -> frozenset[Query]:
    """Return a crossed subset of at most `most` queries; the least worthy ones are dropped one by one."""
    kept = prune(queries)
    while len(kept) > most:
        order = sorted(kept, key=lambda query: (query.relation, query.category))
        kept = max((prune(kept - {query}) for query in order), key=rate)
    return kept


Role = Literal["displaced", "appearing", "removed", "moving"]
"""Changes of one instance between the visits."""
ROLES: tuple[Role, ...] = get_args(Role)


@dataclass(frozen=True)
class Script:
    """The changes of a scene between the visits, by ids of instances: each instance has at most one."""

    displaced: Mapping[str, Alteration] = field(hash=False)
    appearing: frozenset[str]
    removed: frozenset[str]
    moving: frozenset[str]

    @cached_property
    def changed(self) -> frozenset[str]:
        """All instances that change."""
        return frozenset(self.displaced) | self.appearing | self.removed | self.moving


@dataclass(frozen=True)
class Referent:
    """The instance that a query means, and where its answer is expected, (x, z) in metres."""

    target: str
    at: Point


class Stage:
    """A scene as scripts are drawn for it: what the tours are expected to show, and where things can go."""

    def __init__(self, scene: Scene, drawing: Drawing, constants: Settings) -> None:
        """Survey the instances of the scene. constants: candidates, mover, primitives.step_m and benchmark.seed."""
        assert drawing.split.crossed is not None
        self.scene, self.drawing, self.constants, self.terms = scene, drawing, constants, drawing.split.crossed
        self.keeps_free = places_of_agent(scene, drawing.tours)
        self.by_id = {item.id: item for item in scene.objects}
        self.rng = seeds.generator(constants.benchmark.seed, "scripts", drawing.split.name, scene.scene)
        self._sights = [Sight.of(scene, tour.waypoints) for tour in (drawing.tours.first, drawing.tours.second)]
        self._cells = np.array(sorted(scene.reachable))
        free = [item for item in scene.objects if item.dynamic and not carries(scene, item)]
        self.angles = {item.id: [self._angle(sight, item) for sight in self._sights] for item in scene.objects if item.dynamic}
        self.seen = {item.id: [angle >= SURE_SR for angle in self.angles[item.id]] for item in free}
        self.near = {item.id: self._nearest_m(item.place) <= NEAR_FLOOR_M for item in free}
        by_noun: dict[str, list[SceneObject]] = {}
        for item in free:
            if any(self.seen[item.id]):
                by_noun.setdefault(item.category, []).append(item)
        self.number = Counter(item.category for item in scene.objects)
        self.nouns = {noun: items for noun, items in sorted(by_noun.items()) if self.number[noun] >= FEWEST}

    @cached_property
    def displacements(self) -> Mapping[str, list[Alteration]]:
        """Where each instance may be put: to its second place in a home, else to free floor or a surface."""
        found = {}
        for item in (item for items in self.nouns.values() for item in items if self.seen[item.id][0]):
            places = [made for made in self._places(item) if self._is_shown(item, made)]
            if places:
                found[item.id] = places
        return found

    @cached_property
    def mobile(self) -> frozenset[str]:
        """Instances that can move from where they stand and that the second tour shows."""
        return frozenset(k for k in self.scene.mobile if k in self.seen and self.seen[k][1])

    def _places(self, item: SceneObject) -> list[Alteration]:
        height_m = round(self.scene.floor_y + ABOVE_SURFACE_M, 4)
        if self.scene.rooms is not None:
            if (spare := item.spare) is None:
                return []
            return [
                Alteration(
                    kind="displace", instance=item.id, placement=(spare.x, spare.z), height_m=height_m, yaw_deg=spare.yaw_deg
                )
            ]
        rng = seeds.generator(self.constants.benchmark.seed, "places", *self.drawing.split.stream, self.scene.scene, item.id)
        floor = FreeFloor.of(self.scene, item, self.constants.primitives.step_m, self.keeps_free)
        least_m = self.constants.candidates.delta_min_m + SETTLES_M
        return list(islice(displacements(self.scene, item, floor, least_m, rng), PLACES))

    def _is_shown(self, item: SceneObject, made: Alteration) -> bool:
        """Return whether the second tour is expected to record an instance at its placement, with a cell next to it."""
        assert made.placement is not None and made.height_m is not None
        there = item.turned(made.yaw_deg).moved_to(x=made.placement[0], y=made.height_m + item.size.y / 2, z=made.placement[1])
        return self._nearest_m(made.placement) <= NEAR_FLOOR_M and self._angle(self._sights[1], there) >= SURE_SR

    @staticmethod
    def _angle(sight: Sight, item: SceneObject) -> float:
        return sight.solid_angle(item, (item.position.x, item.position.y, item.position.z))

    def _nearest(self, at: Point) -> Point:
        """Return the cell next to a point, in metres."""
        x, z = self._cells[int(np.hypot(*(self._cells - np.asarray(at)).T).argmin())]
        return float(x), float(z)

    def _nearest_m(self, at: Point) -> float:
        return math.dist(self._nearest(at), at)

    def search(self, rng: np.random.Generator) -> Iterator[Script]:
        """Yield the best scripts of several searches, each of which changes the role of one instance at a time, best first."""
        options = [(noun, item, role) for noun, items in self.nouns.items() for item in items for role in self._find_roles(item)]
        found: list[tuple[float, int, Script]] = []
        for number in range(SEARCHES if options else 0):
            beginnings = [self._begin(number % 3, rng) for _ in range(BEGINNINGS)]
            roles = max(beginnings, key=lambda one: self.rate(self._script(one, rng)))
            script = self._script(roles, rng)
            best = self.rate(script)
            among = [option for option in options if option[2] != "moving" or script.moving]
            for _ in range(STEPS):
                noun, item, role = among[int(rng.integers(len(among)))]
                of_noun = {k: given for k, given in roles.items() if self.by_id[k].category == noun}
                if roles.get(item.id) == role:
                    tried = {k: given for k, given in roles.items() if k != item.id}
                elif all(_are_different(item, self.by_id[k]) for k, given in of_noun.items() if k != item.id and given != role):
                    # At most one instance of a noun has a role, so that the relation has one referent (Eq. 2).
                    tried = {k: given for k, given in roles.items() if k not in of_noun or given != role} | {item.id: role}
                else:
                    continue
                if list(tried.values()).count("moving") > MOVERS:
                    continue
                proposed = self._script(tried, rng)
                worth = self.rate(proposed)
                if worth >= best:
                    roles, best, script = tried, worth, proposed
            found.append((-best, number, script))
        return (script for _, _, script in sorted(found, key=lambda one: one[:2]))

    def _begin(self, kind: int, rng: np.random.Generator) -> dict[str, Role]:
        """Return roles to begin a search with, in two nouns: none (0), movers (1), or all but one instance change (2)."""
        roles: dict[str, Role] = {}
        for noun in [list(self.nouns)[k] for k in rng.permutation(len(self.nouns))]:
            items = [self.nouns[noun][k] for k in rng.permutation(len(self.nouns[noun]))]
            given: dict[str, Role] = {}
            if kind == 1:
                given = {item.id: "moving" for item in items if item.id in self.mobile}
                given = dict(list(given.items())[:1])
            elif kind == 2 and len(items) == self.number[noun]:
                first = next((item for item in items if item.id in self.displacements), None)
                others = [item for item in items if item is not first][: len(items) - 2]
                if first is not None and len(others) <= 2:
                    given = {first.id: "displaced", **{item.id: role for item, role in zip(others, ROLES[1:3], strict=False)}}
            if given and len({self.by_id[k].category for k in roles}) < FEWEST:
                roles |= given
        return roles

    def _find_roles(self, item: SceneObject) -> list[Role]:
        first, second = self.seen[item.id]
        may = {
            "displaced": item.id in self.displacements,
            "appearing": second,
            "removed": first,
            "moving": item.id in self.mobile,
        }
        return [role for role in ROLES if may[role]]

    def _script(self, roles: Mapping[str, Role], rng: np.random.Generator) -> Script:
        def having(role: Role) -> list[str]:
            return [k for k, given in roles.items() if given == role]

        places = {k: self.displacements[k] for k in having("displaced")}
        displaced = {k: found[int(rng.integers(len(found))) if len(found) > 1 else 0] for k, found in places.items()}
        return Script(displaced, frozenset(having("appearing")), frozenset(having("removed")), frozenset(having("moving")))

    def rate(self, script: Script) -> float:
        """Return the worth of a script: that of its crossed queries, and a small share for queries that are not crossed yet."""
        defined = self.find_queries(script)
        asked = limit(defined, self.terms.queries[1] + RESERVE)
        worth = rate(asked) + HOPE * len(defined)
        worth += IDENTITY * sum(self._needs_identity(noun, script) for noun in {query.category for query in asked})
        return worth if self._find_clear(self._keep_from(script, {query: defined[query] for query in asked})).any() else worth / 2

    def _needs_identity(self, noun: str, script: Script) -> bool:
        """Return whether one instance of a noun moves, another vanishes and a third appears."""
        return all(
            any(self.by_id[k].category == noun for k in ids) for ids in (script.displaced, script.appearing, script.removed)
        )

    def find_queries(self, script: Script) -> dict[Query, Referent]:
        """Return the queries that a script defines and that are expected to pass all later checks, before they are crossed."""
        referents: dict[Query, Referent] = {}
        for noun in {self.by_id[k].category for k in script.changed}:
            of_noun = [item for item in self.scene.objects if item.category == noun]
            for relation, (target, at) in self._referents(noun, of_noun, script).items():
                gone = script.appearing if relation.past else script.removed
                there = [o for o in of_noun if o.id not in gone and o.id in self.seen and self.seen[o.id][int(not relation.past)]]
                if len(there) >= FEWEST:
                    referents[Query(noun, relation)] = Referent(target, at)
        stable = {one.target: one.at for query, one in referents.items() if query.relation is Relation.STABLE}
        return {
            query: one
            for query, one in referents.items()
            if self._is_apart(query, one, script, stable)
            and (query.relation is not Relation.MOVING or self.find_floor(one.target, script) is not None)
        }

    def _referents(self, noun: str, of_noun: Sequence[SceneObject], script: Script) -> dict[Relation, tuple[str, Point]]:
        """Return the only instance under each relation (Eq. 2), with its answer (Eq. 3), where tour and floor allow it."""
        found: dict[Relation, tuple[str, Point]] = {}

        def add(relation: Relation, ids: Iterable[str], which: Sequence[int], near: bool = True) -> None:
            only = list(ids)
            if len(only) == 1 and all(self.seen[only[0]][k] for k in which) and (self.near[only[0]] or not near):
                found[relation] = only[0], self.by_id[only[0]].place

        ids = {item.id for item in of_noun}
        # What one tour records and the other one misses looks as if it had come or gone.
        both = [self.angles[k] for k in ids - script.changed if k in self.angles]
        if not any(second >= MAYBE_SR and first < SURE_SR for first, second in both):
            add(Relation.APPEARED, ids & script.appearing, [1])
        if not any(first >= MAYBE_SR and second < SURE_SR for first, second in both):
            add(Relation.REMOVED, ids & script.removed, [0])
        add(Relation.MOVING, ids & script.moving, [1], near=False)
        if not ids & script.moving:  # a mover may end its tour as a displaced instance
            displaced = ids & script.displaced.keys()
            add(Relation.MOVED, displaced, [0], near=False)
            add(Relation.FORMER, displaced, [0])
            if Relation.MOVED in found:
                (target,) = displaced
                placement = script.displaced[target].placement
                assert placement is not None
                found[Relation.MOVED] = target, placement
            staying = ids - script.changed
            if displaced and staying <= self.seen.keys():
                add(Relation.STABLE, staying, [0, 1])
        return found

    def places(self, instance: str, script: Script) -> list[Point]:
        """Return where an instance stands in the visits that it is in."""
        made = script.displaced.get(instance)
        own = self.by_id[instance].place
        return [own] if made is None or made.placement is None else [own, made.placement]

    def _is_apart(self, query: Query, referent: Referent, script: Script, stable: Mapping[str, Point]) -> bool:
        """Return whether an answer, and a stop at the cell next to it, keep apart from rivals. stable: as for `rivals`."""
        rivals = [
            point
            for item in self.scene.objects
            if item.id != referent.target and (item.category == query.category or item.id in script.changed)
            for point in self.places(item.id, script)
        ]
        rivals += [point for point in self.places(referent.target, script) if point != referent.at]
        rivals += [point for k, point in stable.items() if k != referent.target]
        stop, apart_m = self._nearest(referent.at), self.terms.apart_m + SETTLES_M
        stop_m = math.dist(stop, referent.at) + MARGIN_M if query.relation is not Relation.MOVING else 0.0
        return all(math.dist(referent.at, point) >= apart_m and math.dist(stop, point) >= stop_m for point in rivals)

    def drop_unasked(self, script: Script, queries: Mapping[Query, Referent]) -> Script:
        """Return a script without the changes that no query asks about and that no query needs."""
        for k in sorted(script.changed - {referent.target for referent in queries.values()}):
            less = Script(
                {name: made for name, made in script.displaced.items() if name != k},
                *(ids - {k} for ids in (script.appearing, script.removed, script.moving)),
            )
            if queries.keys() <= self.find_queries(less).keys():
                script = less
        return script

    def carry_out(
        self, script: Script, rng: np.random.Generator, pair: str
    ) -> tuple[tuple[tuple[Alteration, ...], ...], list[Point]] | None:
        """Return the alterations of both visits, and where movers are expected at the end of the second tour.

        None if a mover has no floor of its own, or stays near its start. pair: names the movers' stream.
        """
        first = tuple(Alteration(kind="disable", instance=k) for k in sorted(script.appearing))
        gone = tuple(Alteration(kind="disable", instance=k) for k in sorted(script.removed))
        motions, ends, order = [], [], [sorted(script.moving)[k] for k in rng.permutation(len(script.moving))]
        streams = spawn_streams(seeds.generator(self.constants.benchmark.seed, *seeds.tour_movers(pair)), len(order))
        steps = len(self.drawing.tours.second.waypoints) * self.drawing.tours.second.headings
        for k, stream in zip(order, streams, strict=True):
            floor = self.find_floor(k, script)
            if floor is None:
                return None
            path = [mover.position for mover in walk(Mover.setting_off(floor, stream), self.constants.mover, stream, steps)]
            if max(math.dist(point, (floor.x, floor.z)) for point in path) < self._least_m:
                return None
            motions.append(Alteration(kind="motion", instance=k, roam=floor))
            ends.append(path[-1])
        return (first, (*motions, *(made for _, made in sorted(script.displaced.items())), *gone)), ends

    def draw_spawn(
        self, script: Script, queries: Mapping[Query, Referent], ends: Sequence[Point], rng: np.random.Generator
    ) -> Spawn | None:
        """Draw the spawn of a pair: away from changes, answers, the cells next to answers, and the ends of movers."""
        clearance_m = self.constants.candidates.spawn_clearance_m + SETTLES_M
        keep_from = self._keep_from(script, queries) + [(end, clearance_m) for end in ends]
        return pick_spawn(self._cells[self._find_clear(keep_from)], self.constants.tour.headings, rng)

    def _keep_from(self, script: Script, queries: Mapping[Query, Referent]) -> list[tuple[Point, float]]:
        """Return points and the distances that a spawn keeps from them, metres: changes, answers and the cells next to these."""
        clearance_m, beyond_m = self.constants.candidates.spawn_clearance_m, self.constants.success.radius_m
        keep_from: list[tuple[Point, float]] = []
        for k in script.changed:
            least_m = max(clearance_m, math.hypot(*self.by_id[k].half) + beyond_m) + SETTLES_M
            keep_from += [(point, least_m) for point in self.places(k, script)]
        for referent in queries.values():
            half_m = math.hypot(*self.by_id[referent.target].half)
            keep_from.append((referent.at, half_m + beyond_m + SETTLES_M))
            keep_from.append((self._nearest(referent.at), beyond_m + SETTLES_M))
        return keep_from

    def _find_clear(self, keep_from: Sequence[tuple[Point, float]]) -> np.ndarray:
        """Return (K,) whether a cell is off all second places and keeps its distances."""
        points, least_m = (
            np.array([point for point, _ in keep_from]).reshape(-1, 2),
            np.array([metres for _, metres in keep_from]),
        )
        away = np.hypot(*(self._cells[:, None] - points).transpose(2, 0, 1)) >= least_m
        clear: np.ndarray = away.all(axis=1) & self._off_spares
        return clear

    @cached_property
    def _off_spares(self) -> np.ndarray:
        return self.scene.are_off_spares(self._cells, AGENT_RADIUS_M)

    @cached_property
    def _floors(self) -> Mapping[str, Roam | None]:
        """The floor that each mobile instance can roam if nothing stands on a second place, or everything does."""
        there = self.scene.model_copy(update={"objects": (*self.scene.objects, *filter(None, map(_spared, self.scene.objects)))})
        step_m = self.constants.primitives.step_m
        items = [self.by_id[k] for k in sorted(self.mobile)]
        return {o.id: roam(there, o, FreeFloor.of(there, o, step_m, self.keeps_free), self.constants.mover.step_m) for o in items}

    def find_floor(self, instance: str, script: Script) -> Roam | None:
        """Return the floor that a mover of a script may roam: away from all other places of changes and of its noun.

        Two movers stay on their own sides of the line half-way between them. None if the mover could not leave its place.
        """
        floor, item = self._floors[instance], self.by_id[instance]
        away = [p for other in script.changed - {instance} for p in self.places(other, script)]
        away += [o.place for o in self.scene.objects if o.category == item.category and o.id != instance]
        away += [made.placement for made in script.displaced.values() if made.placement is not None]
        floor = None if floor is None else cut(floor, away, self.terms.apart_m + SETTLES_M)
        for other in script.moving - {instance}:
            if floor is not None:
                floor = side(floor, self.by_id[other].place, math.hypot(*item.half) + self.terms.apart_m / 2)
        if floor is None or max(math.dist(floor.at(cell), item.place) for cell in floor.cells) < self._least_m:
            return None
        return floor

    @property
    def _least_m(self) -> float:
        """How far a mover gets from its start in the tour, at least, metres."""
        return max(self.constants.candidates.mover_min_m, self.constants.admissibility.mover_spread_m)


def _spared(item: SceneObject) -> SceneObject | None:
    """Return a thing at its second place, if it has one."""
    if (spare := item.spare) is None:
        return None
    there = item.turned(spare.yaw_deg).moved_to(x=spare.x, y=item.position.y, z=spare.z)
    return there.model_copy(update={"id": f"{item.id}|spare"})


def _are_different(one: SceneObject, other: SceneObject) -> bool:
    """Return whether two things can be told apart by their looks. The engine tints every instance of a floor plan."""
    return one.asset is None or other.asset is None or looks_different(one.asset, other.asset)


def draw_candidates(scene: Scene, drawing: Drawing, constants: Settings) -> list[Candidate]:
    """Draw the world pairs of a scene: one candidate per query, with the same changes, tours and spawn in each pair.

    Pairs of a scene differ in their changes. The list is empty if the scene gives no pair.
    """
    stage, terms = Stage(scene, drawing, constants), drawing.split.crossed
    assert terms is not None
    drawn: list[Candidate] = []
    taken: set[Script] = set()
    for number in range(terms.pairs):
        drawn += _draw_pair(stage, number, taken, Counter(candidate.relation for candidate in drawn))
    return drawn


def _draw_pair(stage: Stage, number: int, taken: set[Script], numbers: Counter[Relation]) -> list[Candidate]:
    """Draw a world pair whose script is not `taken`, and take it. numbers: of the scene's candidates so far, by relation."""
    fewest, most = stage.terms.queries
    for script in stage.search(stage.rng):
        defined = stage.find_queries(script)
        queries = {
            query: defined[query] for query in sorted(limit(defined, most + RESERVE), key=lambda q: (q.relation, q.category))
        }
        if len(queries) < fewest:
            return []
        script = stage.drop_unasked(script, queries)
        if script in taken:
            continue
        # Another name gives movers another walk.
        for attempt in range(WALKS if script.moving else 1):
            pair = f"{stage.scene.scene}/{stage.drawing.split.name}-{WALKS * number + attempt}"
            if (carried := stage.carry_out(script, stage.rng, pair)) is None:
                continue
            visits, ends = carried
            if (spawn := stage.draw_spawn(script, queries, ends, stage.rng)) is not None:
                taken.add(script)
                return _candidates(stage, pair, queries, script, visits, spawn, numbers)
    return []


def _candidates(
    stage: Stage,
    pair: str,
    queries: Mapping[Query, Referent],
    script: Script,
    visits: tuple[tuple[Alteration, ...], ...],
    spawn: Spawn,
    numbers: Counter[Relation],
) -> list[Candidate]:
    drawing, scene = stage.drawing, stage.scene
    tours = drawing.tours_of(pair, stage.constants.benchmark.seed)
    stable = {referent.target: referent.at for query, referent in queries.items() if query.relation is Relation.STABLE}
    drawn = []
    for query, referent in sorted(queries.items(), key=lambda one: (list(Relation).index(one[0].relation), one[0].category)):
        displaced = [k for k in script.displaced if stage.by_id[k].category == query.category]
        drawn.append(
            Candidate(
                id=drawing.id(scene.scene, query.relation.value, numbers[query.relation]),
                pair=pair,
                split=drawing.split.name,
                scene=scene.scene,
                relation=query.relation,
                category=query.category,
                target=referent.target,
                distractor=displaced[0] if query.relation is Relation.STABLE else None,
                tours=tours,
                first=visits[0],
                second=visits[1],
                others={k: c for k in sorted(script.changed) if (c := stage.by_id[k].category) != query.category},
                spawn=spawn,
                stable=stable,
                rules=drawing.split.rules,
                refused=None,
            )
        )
        numbers[query.relation] += 1
    return drawn
