"""What else changes between the visits: instances of other categories, of the size of the scripted one, away from it. Pure.

Of each kind of change as many are drawn as the split asks for, of instances and places that the tours are foreseen to record.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np

from ovman.generation import placement
from ovman.generation.beside import Beside, meets
from ovman.generation.placement import CLEARANCE_M
from ovman.generation.roaming import goes_m, roam, side
from ovman.generation.script import KIND_OF, Kind, Script
from ovman.records.change import Alteration
from ovman.records.query import Query
from ovman.records.rejection import Rejection
from ovman.records.relation import Relation
from ovman.records.scene import Scene, SceneObject
from ovman.settings import Settings
from ovman.sim.world import spawn_streams

KINDS: tuple[Kind, ...] = ("displace", "enable", "disable")
"""What may change beside any scripted change; instances move on their own beside such a one only."""
PLACED = frozenset((Relation.MOVED, Relation.FORMER, Relation.APPEARED, Relation.REMOVED))
"""Relations whose answer is where a change is scripted, from the start of the second visit on."""
NOBODY: Mapping[str, str] = MappingProxyType({})
"""No other changes."""


@dataclass(frozen=True)
class Found:
    """All alterations of both visits, the scripted ones first, and the categories of the other instances by their ids."""

    first: tuple[Alteration, ...]
    second: tuple[Alteration, ...]
    categories: Mapping[str, str]


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
    answers with any. Likewise categories with several instances go first: of the queried one there are several, and what changes
    alike is as free of its like as the answer (candidates.crowding_m): what changes among its like is hard to see. The others are
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
    likes: list[Script] = []

    def like(item: SceneObject) -> Script:
        return Script(beside.scene, Query(item.category, relation), item.id)

    def uncrowded(item: SceneObject, kind: Kind, made: Alteration) -> bool:
        """Whether every instance that changes as the scripted one does stays as free of its like as the answer has to be."""
        if relation not in PLACED:
            return True
        visits = ((*first, made), second) if kind == "enable" else (first, (*second, made))
        apart_m = constants.candidates.crowding_m
        return not any(one.crowded(*visits, apart_m) for one in (*likes, *([like(item)] if kind == own else [])))

    for number in range(wanted):
        turns: list[Kind] = [own] if number < alike else [KINDS[k] for k in rng.permutation(len(KINDS))]
        ranked = pool if number >= alike else larger if number < above else smaller
        ranked = sorted(ranked, key=lambda o: o.category not in beside.several)
        options = ((kind, o) for kind in turns for o in ranked if o.id not in categories and not _touch(o, full))
        chosen = next(
            (
                (kind, o, made)
                for kind, o in options
                if (made := beside.made(o, kind, away, full, partial(uncrowded, o, kind), rng)) is not None
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
    for item, stream in zip(moving, spawn_streams(walk_rng, len(moving)), strict=True):
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


def _touch(item: SceneObject, full: Sequence[SceneObject]) -> bool:
    """Whether an instance is on, under or in one of these: a change of the one would change the other."""
    return any(item.id == o.id or o.id in item.parents or item.id in o.parents for o in full) or meets(
        item, (item.position.x, item.position.z), full
    )
