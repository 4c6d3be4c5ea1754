"""Candidates of which several instances of one category change, each under another relation. Pure.

A choice of who changes how fixes a pair of tours, and every relation that it leaves exactly one referent (Eq. 2) is
a query of its own. That is decided before a simulator brings anything about, and again by the trials, on what was recorded.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ovman import seeds
from ovman.generation.candidates import displacement, eligible, motion
from ovman.generation.placement import FreeFloor, put
from ovman.generation.protocol import Drawing, keeps_free
from ovman.generation.roaming import roam
from ovman.generation.script import Script
from ovman.generation.spawning import spawn
from ovman.records.candidate import Candidate
from ovman.records.change import Alteration
from ovman.records.geometry import Point
from ovman.records.query import Query
from ovman.records.rejection import Rejection
from ovman.records.relation import Relation
from ovman.records.scene import Scene, SceneObject
from ovman.settings import Settings

Roles = Mapping[str, Relation]
"""Under which relation each instance that is changed changes, by its id: one of KINDS."""
KINDS = (Relation.MOVED, Relation.MOVING, Relation.APPEARED, Relation.REMOVED)
"""The relations that a scripted change brings about. FORMER asks about the first, STABLE about an instance that stays."""
ALTERNATIVES = 4
"""Of so many draws the one that serves most of the queries that are lacking still is taken: tours cost more than draws."""


@dataclass(frozen=True)
class Changes:
    """What is different in each visit of a pair of tours.

    items: the instances of the category; refused: why nothing could be drawn, else None.
    """

    items: Sequence[SceneObject]
    roles: Roles
    first: tuple[Alteration, ...]
    second: tuple[Alteration, ...]
    refused: Rejection | None


def referents(ids: Sequence[str], roles: Roles, relation: Relation) -> tuple[str, ...]:
    """Those of the instances `ids` of a category for which Eq. 1's predicate of `relation` may hold once the changes are made.

    Where a mover will be at the end of its tour is not known: it may have been displaced or be where it was.
    """
    holding: tuple[Relation | None, ...] = (relation,)
    if relation in (Relation.MOVED, Relation.FORMER):
        holding = (Relation.MOVED, Relation.MOVING)
    elif relation is Relation.STABLE:
        if not {Relation.MOVED, Relation.MOVING} & {*roles.values()}:
            return ()
        holding = (None, Relation.MOVING)
    return tuple(k for k in ids if roles.get(k) in holding)


def asked(ids: Sequence[str], roles: Roles) -> tuple[Relation, ...]:
    """The relations that a pair of tours is asked about: exactly one referent, and two instances of the category in a visit.

    A mover draws its path under the id of the one episode that it is of, so a pair of tours with a mover is asked about it alone.
    """
    changed = Counter(roles.values())
    if len(ids) - min(changed[Relation.APPEARED], changed[Relation.REMOVED]) < 2:
        return ()
    relations = [Relation.MOVING] if Relation.MOVING in changed else list(Relation)
    return tuple(relation for relation in relations if len(referents(ids, roles, relation)) == 1)


def role_sets(count: int, changes: Sequence[int]) -> Iterator[tuple[Relation, ...]]:
    """The relations under which instances of a category of `count` change. changes: how many of them may."""
    for size in sorted(changes):
        if size <= count:
            yield from combinations(KINDS, size)


def draw(
    scene: Scene,
    items: Sequence[SceneObject],
    roles: Roles,
    relation: Relation,
    constants: Settings,
    rng: np.random.Generator,
    waypoints: Sequence[Point],
) -> Changes:
    """The alterations that `roles` ask for, drawn for a query for `relation`, whose answer they leave uncrowded.

    What is displaced is put first, so that a mover is given a way around it. waypoints: to leave free.
    """
    by_id = {item.id: item for item in items}
    (target,) = referents(list(by_id), roles, relation)
    script = Script(scene, Query(by_id[target].category, relation), target)
    first = tuple(Alteration(kind="disable", instance=k) for k, role in roles.items() if role is Relation.APPEARED)
    second = tuple(Alteration(kind="disable", instance=k) for k, role in roles.items() if role is Relation.REMOVED)
    there = scene
    for role in (Relation.MOVED, Relation.MOVING):
        for item in (by_id[k] for k, given in roles.items() if given is role):
            floor = FreeFloor.of(there, item, constants.primitives.step_m, waypoints)

            def uncrowded(made: Alteration, before: tuple[Alteration, ...] = second) -> bool:
                return not script.crowded(first, (*before, made), constants.candidates.crowding_m)

            if role is Relation.MOVED:
                drawn = displacement(there, item, floor, constants.candidates.delta_min_m, uncrowded, rng)
            else:
                drawn = motion(there, item, floor, constants.mover.step_m)
            if isinstance(drawn, Rejection):
                return Changes(items, roles, first, second, drawn)
            second = (*second, drawn)
            if drawn.placement is not None and drawn.height_m is not None:
                there = put(there, item, drawn.placement, drawn.height_m)
    return Changes(items, roles, first, second, None)


def _changes(scene: Scene, drawing: Drawing, constants: Settings, lacking: Counter[Relation]) -> Iterator[Changes]:
    """Changes for what is `lacking` still, which the reader counts down: the relation that lacks most chooses what changes.

    Categories take turns for each relation. Nothing is drawn for a relation that no category can serve.
    """
    rng = seeds.generator(constants.benchmark.seed, "changes", drawing.split, scene.scene)
    by_category = eligible(scene)
    step_m, waypoints = constants.primitives.step_m, keeps_free(scene, drawing.tours)
    floors = {item.id: FreeFloor.of(scene, item, step_m, waypoints) for items in by_category.values() for item in items}
    can_move = {
        item.id
        for items in by_category.values()
        for item in items
        if roam(scene, item, floors[item.id], constants.mover.step_m) is not None
    }
    served = {relation: _served(by_category, drawing, relation, can_move) for relation in Relation}
    order = {relation: [list(found)[k] for k in rng.permutation(len(found))] for relation, found in served.items()}
    limit = {relation: (drawing.tries or 1) * count for relation, count in lacking.items()}
    turns: Counter[Relation] = Counter()
    while left := [one for one in Relation if lacking[one] > 0 and order[one] and turns[one] < limit[one]]:
        relation = min(left, key=lambda one: (-lacking[one], turns[one]))
        category = order[relation][turns[relation] % len(order[relation])]
        turns[relation] += 1
        items, sets = by_category[category], served[relation][category]
        alternatives = []
        for _ in range(ALTERNATIVES):
            roles = sets[int(rng.integers(len(sets)))]
            alternatives.append(draw(scene, items, _given(items, roles, can_move, rng), relation, constants, rng, waypoints))
        yield max(alternatives, key=lambda changes: sum(lacking[one] > 0 for one in _uncrowded(scene, changes, constants)))


def _given(items: Sequence[SceneObject], roles: Sequence[Relation], can_move: Container[str], rng: np.random.Generator) -> Roles:
    """Who changes how: instances in random order, the mover one of those that can move from where they stand."""
    left = [items[k].id for k in rng.permutation(len(items))]
    given = {}
    for role in sorted(roles, key=lambda one: one is not Relation.MOVING):
        who = next(k for k in left if role is not Relation.MOVING or k in can_move)
        left.remove(who)
        given[who] = role
    return given


def _uncrowded(scene: Scene, changes: Changes, constants: Settings) -> list[Relation]:
    """The relations that a pair of tours is asked about and whose answers are not crowded; none where it could not be drawn."""
    if changes.refused is not None:
        return []
    ids = [item.id for item in changes.items]
    scripts = {}
    for relation in asked(ids, changes.roles):
        (target,) = referents(ids, changes.roles, relation)
        scripts[relation] = Script(scene, Query(changes.items[0].category, relation), target)
    apart_m = constants.candidates.crowding_m
    return [one for one, script in scripts.items() if not script.crowded(changes.first, changes.second, apart_m)]


def _served(
    by_category: Mapping[str, Sequence[SceneObject]], drawing: Drawing, relation: Relation, can_move: Container[str]
) -> dict[str, list[tuple[Relation, ...]]]:
    """By category the sets of changes after which `relation` has exactly one referent; without categories that have none.

    can_move: ids of the instances that can move from where they stand; a set with a mover needs one.
    """
    found = {}
    for category, items in by_category.items():
        ids = [item.id for item in items]
        sets = [
            roles
            for roles in role_sets(len(ids), drawing.changes)
            if relation in asked(ids, dict(zip(ids, roles, strict=False)))
            and (Relation.MOVING not in roles or any(k in can_move for k in ids))
        ]
        if sets:
            found[category] = sets
    return found


def candidates(scene: Scene, drawing: Drawing, constants: Settings) -> list[Candidate]:
    """The candidates of a scene for a split, in the order in which they are drawn. What was refused is there beside what is asked
    for.

    Deterministic under benchmark.seed, split by split.
    """
    lacking = Counter({relation: getattr(drawing.draws, relation.value) for relation in Relation})
    numbers: Counter[Relation] = Counter()
    drawn = []
    for changes in _changes(scene, drawing, constants, lacking):
        for relation in (one for one in asked([item.id for item in changes.items], changes.roles) if lacking[one] > 0):
            name = drawing.id(scene.scene, relation.value, numbers[relation])
            numbers[relation] += 1
            drawn.append(_candidate(name, scene, drawing, changes, relation, constants))
            lacking[relation] -= drawn[-1].refused is None
    return drawn


def _candidate(name: str, scene: Scene, drawing: Drawing, changes: Changes, relation: Relation, constants: Settings) -> Candidate:
    """The query for `relation` in a pair of tours with `changes`."""
    (target,) = referents([item.id for item in changes.items], changes.roles, relation)
    (item,) = (item for item in changes.items if item.id == target)
    refused, begins = changes.refused, None
    if refused is None:
        script = Script(scene, Query(item.category, relation), target)
        if script.crowded(changes.first, changes.second, constants.candidates.crowding_m):
            refused = Rejection.CROWDED
        else:
            floor = FreeFloor.of(scene, item, constants.primitives.step_m, keeps_free(scene, drawing.tours))
            rng = seeds.generator(constants.benchmark.seed, "spawn", name)
            begins = spawn(script, item, changes.first, changes.second, floor, constants, rng)
            refused = Rejection.NO_SPAWN if begins is None else None
    displaced = [k for k, role in changes.roles.items() if role is Relation.MOVED]
    return Candidate(
        id=name,
        split=drawing.split,
        scene=scene.scene,
        relation=relation,
        category=item.category,
        target=target,
        distractor=displaced[0] if relation is Relation.STABLE else None,
        tours=drawing.of_candidate(name, constants.benchmark.seed),
        first=changes.first,
        second=changes.second,
        others={},
        spawn=begins,
        refused=refused,
    )
