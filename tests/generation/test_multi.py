"""Pairs of tours with several changes: what is asked about them has one referent by Eq. 1 itself, whatever is drawn."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.generation import multi
from ovman.generation.drawing import Drawing, tours
from ovman.records.scene import Scene
from ovman.records.task import Instance, Query, Rejection, Relation, WorldState
from ovman.records.trial import Candidate
from ovman.settings.benchmark import PerRelation
from ovman.task import referents
from tests.arms import CONFIG
from tests.generation.test_placement import room, thing

SPLIT = CONFIG.splits["multi"].model_copy(
    update={"tries": 1, "draws": PerRelation(**{relation.value: 1 for relation in Relation})}
)
FAR_M = CONFIG.candidates.delta_min_m


def worlds(ids: tuple[str, ...], roles: Mapping[str, Relation], gone_by_m: float) -> tuple[WorldState, WorldState]:
    """The world states that roles bring about. gone_by_m: where a mover ends, from where it was."""
    first, second = [], []
    for number, k in enumerate(ids):
        x, role = 10.0 * number, roles.get(k)
        if role is not Relation.APPEARED:
            first.append(Instance(k, "A", x, 0.0))
        if role is Relation.MOVING:
            second.append(Instance.tracked(k, "A", ((x, 0.0), (x, 0.5), (x, gone_by_m))))
        elif role is not Relation.REMOVED:
            second.append(Instance(k, "A", x, FAR_M if role is Relation.MOVED else 0.0))
    return WorldState(tuple(first)), WorldState(tuple(second))


def rooms() -> list[Scene]:
    pair = [thing(f"b|{k}", "B", 0.5 + 2.5 * k, 3.0, size=(0.3, 0.8, 0.3)) for k in range(2)]
    four = [thing(f"a|{k}", "A", 0.5 + 1.5 * k, 1.0, size=(0.3, 0.8, 0.3)) for k in range(4)]
    return [room(*pair, cells=18), room(*pair, *four[:3], cells=18), room(*four, cells=18)]


def drawing(scene: Scene) -> Drawing:
    return Drawing(SPLIT, tours(scene, 4, None))


@cache
def drawn_in(number: int) -> tuple[Candidate, ...]:
    return tuple(multi.draw_candidates(rooms()[number], drawing(rooms()[number]), CONFIG))


@given(st.integers(2, 5).flatmap(lambda n: st.tuples(st.just(n), st.permutations(multi.KINDS), st.integers(2, 3))))
def test_what_is_asked_has_one_referent_wherever_the_mover_ends(drawn):
    count, kinds, size = drawn
    ids = tuple(f"a|{k}" for k in range(count))
    roles = dict(zip(ids, kinds[:size], strict=False))
    moving = Relation.MOVING in roles.values()
    for relation in Relation:
        predicted = multi.find_referents(ids, roles, relation)
        for gone_by_m in (0.0, FAR_M / 2, FAR_M + 1.0):
            true = referents(*worlds(ids, roles, gone_by_m), Query("A", relation), CONFIG)
            assert {*true} <= {*predicted} and (moving or true == predicted)
            if relation in multi.find_queries(ids, roles):
                assert true == predicted and len(true) == 1
    if multi.find_queries(ids, roles):
        assert max(map(len, worlds(ids, roles, 0.0))) >= 2


@pytest.mark.parametrize("number", [0, 1, 2], ids=["a pair", "a pair and three", "four"])
def test_a_candidate_changes_two_or_three_of_its_category_each_in_another_way(number):
    scene, drawn = rooms()[number], drawn_in(number)
    if number == 0:
        assert drawn == tuple(multi.draw_candidates(scene, drawing(scene), CONFIG))
    assert len({c.id for c in drawn}) == len(drawn)
    made = [c for c in drawn if c.refused is None]
    counts = Counter(c.relation for c in made)
    assert counts and all(counts[relation] <= getattr(SPLIT.draws, relation.value) for relation in Relation)
    categories = {o.id: o.category for o in scene.objects}
    for c in made:
        changed = [a.instance for a in c.first + c.second]
        ways = [("first", a.kind) for a in c.first] + [("second", a.kind) for a in c.second]
        assert len(changed) == len({*changed}) in SPLIT.changes and len({*ways}) == len(ways)
        assert {categories[k] for k in changed} == {c.category} == {categories[c.target]}
        assert c.split == SPLIT.name and c.id.startswith(f"{scene.scene}/{c.relation.value}/{SPLIT.name}-")
        assert (c.distractor in changed) == (c.relation is Relation.STABLE) == (c.target not in changed)
        assert ("second", "motion") not in ways or c.relation is Relation.MOVING
        assert c.spawn is not None


def test_what_cannot_be_drawn_is_named():
    """A room without a free place, a way to go, or a spawn away from the target."""
    small = room(thing("a|1", "A", 0.0, 0.0), thing("a|2", "A", 3.0, 0.0), cells=2)
    refused = {c.refused for c in multi.draw_candidates(small, drawing(small), CONFIG)}
    assert refused and refused <= {Rejection.NO_PLACEMENT, Rejection.CANNOT_MOVE, Rejection.NO_SPAWN}
    alone = room(thing("a|1", "A", 0.0, 0.0))
    assert multi.draw_candidates(alone, drawing(alone), CONFIG) == []
