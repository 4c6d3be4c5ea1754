"""Candidates in which several instances of one category change, each under another relation. Pure.

A choice of roles fixes a pair of tours. Every relation with exactly one referent (Eq. 2) is a query. That is decided before any
simulation, and again by the trials on what was recorded.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np

from ovman import seeds
from ovman.generation.drawing import Drawing, draw_displacement, draw_motion, draw_spawn, group_eligible, places_of_agent
from ovman.generation.placement import FreeFloor, put
from ovman.generation.roaming import roam
from ovman.records.geometry import Point
from ovman.records.scene import Alteration, Scene, SceneObject
from ovman.records.task import Rejection, Relation
from ovman.records.trial import Candidate
from ovman.settings import Settings

Roles = Mapping[str, Relation]
"""The relation under which each changed instance changes, one of KINDS, by id."""
KINDS = (Relation.MOVED, Relation.MOVING, Relation.APPEARED, Relation.REMOVED)
"""The relations that a scripted change causes. FORMER asks about the first, STABLE about an instance that stays."""
ALTERNATIVES = 4
"""Of so many draws the one that serves most of the lacking queries is taken, since tours cost more than draws."""


@dataclass(frozen=True)
class Changes:
    """The differences between the visits of a pair of tours.

    items: the instances of the category; refused: why nothing could be drawn, else None.
    """

    items: Sequence[SceneObject]
    roles: Roles
    first: tuple[Alteration, ...]
    second: tuple[Alteration, ...]
    refused: Rejection | None

    @property
    def queries(self) -> tuple[Relation, ...]:
        """The relations with exactly one referent, whether or not the alterations could be drawn."""
        return find_queries([item.id for item in self.items], self.roles)


def find_referents(ids: Sequence[str], roles: Roles, relation: Relation) -> tuple[str, ...]:
    """Return the instances of a category for which Eq. 1's predicate of a relation may hold after the changes.

    The final place of a mover is unknown: it may count as displaced or be where it was.
    """
    holding: tuple[Relation | None, ...] = (relation,)
    if relation in (Relation.MOVED, Relation.FORMER):
        holding = (Relation.MOVED, Relation.MOVING)
    elif relation is Relation.STABLE:
        if not {Relation.MOVED, Relation.MOVING} & {*roles.values()}:
            return ()
        holding = (None, Relation.MOVING)
    return tuple(k for k in ids if roles.get(k) in holding)


def find_queries(ids: Sequence[str], roles: Roles) -> tuple[Relation, ...]:
    """Return the relations of a pair of tours with exactly one referent and two instances of the category in a visit.

    A mover draws its path under the id of its one episode, so a pair of tours with a mover serves the query about it alone.
    """
    changed = Counter(roles.values())
    if len(ids) - min(changed[Relation.APPEARED], changed[Relation.REMOVED]) < 2:
        return ()
    relations = [Relation.MOVING] if Relation.MOVING in changed else list(Relation)
    return tuple(relation for relation in relations if len(find_referents(ids, roles, relation)) == 1)


def list_role_sets(count: int, changes: Sequence[int]) -> Iterator[tuple[Relation, ...]]:
    """Yield the sets of relations under which instances of a category of `count` may change. changes: their numbers."""
    for size in sorted(changes):
        if size <= count:
            yield from combinations(KINDS, size)


def draw_changes(
    scene: Scene,
    items: Sequence[SceneObject],
    roles: Roles,
    constants: Settings,
    rng: np.random.Generator,
    waypoints: Sequence[Point],
) -> Changes:
    """Draw the alterations of `roles`.

    Displaced instances are put first, so that a mover has a way around them. waypoints: to leave free.
    """
    by_id = {item.id: item for item in items}
    first = tuple(Alteration(kind="disable", instance=k) for k, role in roles.items() if role is Relation.APPEARED)
    second = tuple(Alteration(kind="disable", instance=k) for k, role in roles.items() if role is Relation.REMOVED)
    there = scene
    for role in (Relation.MOVED, Relation.MOVING):
        for item in (by_id[k] for k, given in roles.items() if given is role):
            floor = FreeFloor.of(there, item, constants.primitives.step_m, waypoints)
            if role is Relation.MOVED:
                drawn = draw_displacement(there, item, floor, constants.candidates.delta_min_m, rng)
            else:
                drawn = draw_motion(there, item, floor, constants.mover.step_m)
            if isinstance(drawn, Rejection):
                return Changes(items, roles, first, second, drawn)
            second = (*second, drawn)
            if drawn.placement is not None and drawn.height_m is not None:
                there = put(there, item, drawn.placement, drawn.height_m)
    return Changes(items, roles, first, second, None)


def _propose_changes(scene: Scene, drawing: Drawing, constants: Settings, lacking: Counter[Relation]) -> Iterator[Changes]:
    """Yield changes for the `lacking` relations, which the caller counts down; the relation that lacks most chooses.

    Categories take turns for each relation. Nothing is drawn for a relation that no category can serve.
    """
    rng = seeds.generator(constants.benchmark.seed, "changes", drawing.split.name, scene.scene)
    by_category = group_eligible(scene)
    step_m, waypoints = constants.primitives.step_m, places_of_agent(scene, drawing.tours)
    can_move = {
        item.id
        for item in chain.from_iterable(by_category.values())
        if roam(scene, item, FreeFloor.of(scene, item, step_m, waypoints), constants.mover.step_m) is not None
    }
    served = {relation: _served(by_category, drawing, relation, can_move) for relation in Relation}
    order = {relation: [list(found)[k] for k in rng.permutation(len(found))] for relation, found in served.items()}
    limit = {relation: (drawing.split.tries or 1) * count for relation, count in lacking.items()}
    turns: Counter[Relation] = Counter()
    while left := [one for one in Relation if lacking[one] > 0 and order[one] and turns[one] < limit[one]]:
        relation = min(left, key=lambda one: (-lacking[one], turns[one]))
        category = order[relation][turns[relation] % len(order[relation])]
        turns[relation] += 1
        items, sets = by_category[category], served[relation][category]
        alternatives = []
        for _ in range(ALTERNATIVES):
            roles = sets[int(rng.integers(len(sets)))]
            alternatives.append(draw_changes(scene, items, _assign_roles(items, roles, can_move, rng), constants, rng, waypoints))
        yield max(alternatives, key=lambda one: one.refused is None and sum(lacking[k] > 0 for k in one.queries))


def _assign_roles(
    items: Sequence[SceneObject], roles: Sequence[Relation], can_move: Container[str], rng: np.random.Generator
) -> Roles:
    """Assign roles to instances in random order; a mover is one of those that can move from where they stand."""
    left = [items[k].id for k in rng.permutation(len(items))]
    given = {}
    for role in sorted(roles, key=lambda one: one is not Relation.MOVING):
        who = next(k for k in left if role is not Relation.MOVING or k in can_move)
        left.remove(who)
        given[who] = role
    return given


def _served(
    by_category: Mapping[str, Sequence[SceneObject]], drawing: Drawing, relation: Relation, can_move: Container[str]
) -> dict[str, list[tuple[Relation, ...]]]:
    """Return by category the sets of changes after which `relation` has exactly one referent.

    can_move: ids of the instances that can move from where they stand; a set with a mover needs one.
    """
    found = {}
    for category, items in by_category.items():
        ids = [item.id for item in items]
        sets = [
            roles
            for roles in list_role_sets(len(ids), drawing.split.changes)
            if relation in find_queries(ids, dict(zip(ids, roles, strict=False)))
            and (Relation.MOVING not in roles or any(k in can_move for k in ids))
        ]
        if sets:
            found[category] = sets
    return found


def draw_candidates(scene: Scene, drawing: Drawing, constants: Settings) -> list[Candidate]:
    """Draw the candidates of a scene for a split, in their order, including refused ones.

    Deterministic under benchmark.seed, split by split.
    """
    lacking = Counter({relation: getattr(drawing.split.draws, relation.value) for relation in Relation})
    numbers: Counter[Relation] = Counter()
    drawn = []
    for changes in _propose_changes(scene, drawing, constants, lacking):
        for relation in (one for one in changes.queries if lacking[one] > 0):
            name = drawing.id(scene.scene, relation.value, numbers[relation])
            numbers[relation] += 1
            drawn.append(_candidate(name, scene, drawing, changes, relation, constants))
            lacking[relation] -= drawn[-1].refused is None
    return drawn


def _candidate(name: str, scene: Scene, drawing: Drawing, changes: Changes, relation: Relation, constants: Settings) -> Candidate:
    """Return the query for `relation` in a pair of tours with `changes`."""
    (target,) = find_referents([item.id for item in changes.items], changes.roles, relation)
    (item,) = (item for item in changes.items if item.id == target)
    refused, begins = changes.refused, None
    if refused is None:
        floor = FreeFloor.of(scene, item, constants.primitives.step_m, places_of_agent(scene, drawing.tours))
        begins = draw_spawn(item, changes.second, floor, constants, seeds.generator(constants.benchmark.seed, "spawn", name))
        refused = Rejection.NO_SPAWN if begins is None else None
    displaced = [k for k, role in changes.roles.items() if role is Relation.MOVED]
    return Candidate(
        id=name,
        split=drawing.split.name,
        scene=scene.scene,
        relation=relation,
        category=item.category,
        target=target,
        distractor=displaced[0] if relation is Relation.STABLE else None,
        tours=drawing.tours_of(name, constants.benchmark.seed),
        first=changes.first,
        second=changes.second,
        others={},
        spawn=begins,
        rules=drawing.split.rules,
        refused=refused,
    )
