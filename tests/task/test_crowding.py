"""The anti-shortcut rule: what stands near an answer, and what a uniform pick of an instance is worth."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.task import Instance, Query, Relation, WorldState, category_pick, crowding
from tests.task.test_relations import POINTS, RELATIONS, worlds

RADII = st.integers(0, 16).map(lambda quarter: quarter * 0.25)


@given(worlds(), RELATIONS, POINTS, RADII, st.sampled_from(["chair_1", "chair_2"]))
def test_what_crowds_is_found_by_hand_and_grows_with_the_radius(states, relation, at, radius_m, referent):
    query = Query("Chair", relation)
    found = crowding(*states, query, referent, at, radius_m)
    by_hand = set()
    for number, world in enumerate(states, start=1):
        for one in world:
            counts = number == 2 or relation in (Relation.FORMER, Relation.REMOVED)
            near = (one.x - at[0]) ** 2 + (one.z - at[1]) ** 2 <= radius_m**2
            if counts and one.category == "Chair" and one.id != referent and near:
                by_hand.add(one.id)
    assert list(found) == sorted(by_hand)
    assert set(found) <= set(crowding(*states, query, referent, at, radius_m + 0.25))


@given(worlds(moving=False), RELATIONS, RADII)
def test_where_nothing_crowds_a_pick_is_at_chance_in_the_answers_visit_and_no_better_in_the_second(states, relation, radius_m):
    world = states[0] if relation.past else states[1]
    chairs = world.category("Chair")
    for target in chairs:
        query, at = Query("Chair", relation), target.position
        crowds = crowding(*states, query, target.id, at, radius_m)
        if not crowds:
            assert category_pick(world, query, at, radius_m) == pytest.approx(1 / len(chairs))
        else:
            here = [k for k in crowds if k in world and math.dist(world[k].position, at) <= radius_m]
            assert category_pick(world, query, at, radius_m) == pytest.approx((1 + len(here)) / len(chairs))


def test_the_radius_is_inclusive_a_negative_one_is_refused_and_nothing_is_no_pick():
    world, query = (
        WorldState((Instance("a", "Chair", 0.0, 0.0), Instance("b", "Chair", 1.0, 0.0))),
        Query("Chair", Relation.STABLE),
    )
    assert crowding(world, world, query, "a", (0.0, 0.0), 1.0) == ("b",)
    assert crowding(world, world, query, "a", (0.0, 0.0), 0.999) == ()
    assert category_pick(world, query, (0.0, 0.0), 1.0) == 1.0 and category_pick(world, query, (0.0, 0.0), 0.999) == 0.5
    assert category_pick(WorldState(()), query, (0.0, 0.0), 1.0) == 0.0
    with pytest.raises(ValueError, match="at least 0"):
        crowding(world, world, query, "a", (0.0, 0.0), -0.1)
