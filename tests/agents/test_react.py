"""REACT: clusters and matching as properties, and the answers from its output by relation."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.interface import (
    Abstention,
    AbstentionReason,
    Answer,
    Evidence,
    Query,
    Relation,
)
from ovman.agents.react.agent import (
    ReactAgent,
    answer,
    cluster_instances,
    decide_relation,
    match_instances,
    predict_two_visits,
)
from ovman.agents.reference.association import Association
from ovman.perception.clusters import Cluster, ObjectMap
from tests.arms import CONFIG

APPEARANCE = CONFIG.react.appearance
LOOKS = np.eye(4)


CLASSES = np.array([[1, 1, 0, 0], [0, 0, 1, 1]]) / np.sqrt(2)


def objects_of(places, features, views=None) -> ObjectMap:
    tracks = tuple(np.zeros((count, 2)) for count in views or [1] * len(places))
    return ObjectMap(np.array(places, float).reshape(-1, 2), features, tracks, (0,) * len(places))


def seen(*things: tuple[float, float, int]) -> ObjectMap:
    """Instances by x, z and look; the class is that of the look's half."""
    return objects_of([thing[:2] for thing in things], LOOKS[[look for *_, look in things]] if things else np.zeros((0, 4)))


places = st.tuples(st.integers(-8, 8), st.integers(-8, 8)).map(lambda at: (at[0] / 2, at[1] / 2))
homes = st.lists(st.tuples(places, st.integers(0, 3)), max_size=7, unique_by=lambda one: one[0]).map(
    lambda found: seen(*((*place, look) for place, look in found))
)


def reordered(visit: ObjectMap, order) -> ObjectMap:
    return objects_of(visit.p[list(order)], visit.f[list(order)])


@given(homes, homes)
def test_every_instance_is_matched_once_or_absent_or_new(first, second):
    found = match_instances(first, second, CLASSES, APPEARANCE)
    assert sorted([i for i, _ in found.pairs] + list(found.unmatched_1)) == list(range(len(first)))
    assert sorted([j for _, j in found.pairs] + list(found.unmatched_2)) == list(range(len(second)))
    for look in range(len(LOOKS)):
        old, new = (int(np.count_nonzero(visit.f[:, look])) for visit in (first, second))
        same = [(i, j) for i, j in found.pairs if first.f[i, look]]
        assert len(same) == min(old, new) and all(second.f[j, look] for _, j in same)


@given(homes, homes, st.randoms(use_true_random=False))
def test_the_order_of_instances_is_of_no_consequence(first, second, random):
    orders = [random.sample(range(len(visit)), len(visit)) for visit in (first, second)]
    again = match_instances(
        *(reordered(visit, order) for visit, order in zip((first, second), orders, strict=True)), CLASSES, APPEARANCE
    )
    assert sorted((orders[0][i], orders[1][j]) for i, j in again.pairs) == list(
        match_instances(first, second, CLASSES, APPEARANCE).pairs
    )


@given(st.lists(places, min_size=1, max_size=4, unique=True), st.lists(places, min_size=1, max_size=4, unique=True))
def test_alike_instances_travel_least_in_all(old, new):
    first, second = (seen(*((*place, 0) for place in found)) for found in (old, new))
    pairs = match_instances(first, second, CLASSES, APPEARANCE).pairs
    few, many = sorted((old, new), key=len)
    least = min(
        sum(np.hypot(a[0] - b[0], a[1] - b[1]) for a, b in zip(few, chosen, strict=True))
        for chosen in itertools.permutations(many, len(few))
    )
    travelled = sum(float(np.hypot(*(first.p[i] - second.p[j]))) for i, j in pairs)
    assert len(pairs) == len(few) and travelled == pytest.approx(least)


def turned(*degrees: float, views=None) -> ObjectMap:
    angles = np.radians(degrees)
    return objects_of(np.zeros((len(degrees), 2)), np.column_stack([np.cos(angles), np.sin(angles)]), views)


AXES, ONE_CLASS = np.eye(2), np.eye(2)[:1]


def test_another_class_is_never_matched_however_alike():
    found = match_instances(turned(44.0), turned(46.0), AXES, APPEARANCE)
    assert (found.pairs, found.unmatched_1, found.unmatched_2) == ((), (0,), (0,))
    assert match_instances(turned(44.0), turned(44.5), AXES, APPEARANCE).pairs == ((0, 0),)


def test_looks_up_to_the_distance_are_alike():
    apart = 2 * np.degrees(np.arcsin(APPEARANCE / 2))
    assert len(match_instances(turned(0.0), turned(apart - 0.1), ONE_CLASS, APPEARANCE).pairs) == 1
    assert not match_instances(turned(0.0), turned(apart + 0.1), ONE_CLASS, APPEARANCE).pairs


def test_a_cluster_looks_like_the_mean_over_its_views():
    first = turned(0.0, 10.0, views=[3, 1])
    (cluster,) = cluster_instances(first, turned(), ONE_CLASS, APPEARANCE)
    assert cluster.views == 4 and cluster.first == (0, 1) and cluster.second == ()
    assert np.allclose(cluster.feature, 0.75 * first.f[0] + 0.25 * first.f[1])


def test_the_nearest_looks_are_one_cluster_before_others():
    # 10 and 19 degrees are one at 14.5, which is too far from 0 degrees. From 0 and 10 on, all three would have become one.
    found = cluster_instances(turned(0.0, 10.0, 19.0, 40.0), turned(41.0), ONE_CLASS, APPEARANCE)
    assert sorted((one.first, one.second) for one in found) == [((0,), ()), ((1, 2), ()), ((3,), (0,))]


SETTINGS = CONFIG
TAU_M, RADIUS_M = SETTINGS.admissibility.tau_m, CONFIG.success.radius_m
CHAIR, LAMP = np.eye(3)[:2]


def objects(*places: tuple[float, float], last_seen: tuple[int, ...] = ()) -> ObjectMap:
    found = [np.array([place], float) for place in places]
    views = last_seen or tuple(range(len(found)))
    return ObjectMap.of([Cluster(at[0], CHAIR, at, np.array([view])) for at, view in zip(found, views, strict=True)])


FIRST, SECOND = objects((0, 0), (5, 0), (0, 6)), objects((0, 0.2), (9, 0), (3, 3), last_seen=(7, 5, 6))
FOUND = Association(((0, 0), (1, 1)), (2,), (2,))
"""The first stays, the second travels 4 m, the third is absent, and one is new."""


@pytest.mark.parametrize(
    ("relation", "place"),
    [
        (Relation.MOVED, (9, 0)),
        (Relation.FORMER, (5, 0)),
        (Relation.STABLE, (0, 0.2)),
        (Relation.APPEARED, (3, 3)),
        (Relation.REMOVED, (0, 6)),
        (Relation.MOVING, (3, 3)),
    ],
)
def test_each_relation_is_read_off_the_output(relation, place):
    assert decide_relation(relation, FIRST, SECOND, FOUND, SETTINGS) == Answer(*map(float, place))


def test_without_a_moved_one_a_new_or_an_absent_one_is_the_answer():
    still = Association(((0, 0),), (2,), (2,))
    assert decide_relation(Relation.MOVED, FIRST, SECOND, still, SETTINGS) == Answer(3.0, 3.0)
    assert decide_relation(Relation.FORMER, FIRST, SECOND, still, SETTINGS) == Answer(0.0, 6.0)


@pytest.mark.parametrize(
    ("relation", "found", "reason"),
    [
        (Relation.MOVED, Association(((0, 0),), (2,), ()), AbstentionReason.DISPLACEMENT_BELOW_TAU),
        (Relation.FORMER, Association(((0, 0),), (), (2,)), AbstentionReason.DISPLACEMENT_BELOW_TAU),
        (Relation.MOVED, Association((), (2,), ()), AbstentionReason.NO_CANDIDATE),
        (Relation.STABLE, Association(((1, 1),), (2,), (2,)), AbstentionReason.DISPLACEMENT_ABOVE_TAU),
        (Relation.APPEARED, Association(((0, 0),), (2,), ()), AbstentionReason.NO_CANDIDATE),
        (Relation.REMOVED, Association(((0, 0),), (), (2,)), AbstentionReason.NO_CANDIDATE),
        (Relation.MOVING, Association(((0, 0),), (2,), ()), AbstentionReason.NO_CANDIDATE),
    ],
)
def test_what_the_output_does_not_have_is_an_abstention(relation, found, reason):
    assert decide_relation(relation, FIRST, SECOND, found, SETTINGS) == Abstention(reason)


@pytest.mark.parametrize("gone_m", [TAU_M - 0.01, TAU_M])
def test_a_matched_one_has_moved_from_tau_on(gone_m):
    first, second, found = objects((0, 0)), objects((gone_m, 0)), Association(((0, 0),), (), ())
    moved = gone_m >= TAU_M
    assert isinstance(decide_relation(Relation.MOVED, first, second, found, SETTINGS), Answer) is moved
    assert isinstance(decide_relation(Relation.STABLE, first, second, found, SETTINGS), Answer) is not moved
    assert isinstance(decide_relation(Relation.MOVING, first, second, found, SETTINGS), Answer) is moved


def embedding(phrase: str) -> np.ndarray:
    return {"chair": CHAIR, "floor lamp": LAMP}.get(phrase, np.eye(3)[2])


def test_the_evidence_is_what_the_noun_means_and_what_was_taken_for_the_same():
    first, second = objects((0, 0), (5, 0)), objects((0, 0.2))
    outcome, evidence = answer(Relation.REMOVED, first, second, (0, 1), (0,), embedding=embedding, settings=SETTINGS)
    assert (outcome, evidence) == (Answer(5.0, 0.0), Evidence((0, 1), (0,), ((0, 0),)))
    other_end = answer(Relation.REMOVED, first, second, (1,), (0,), embedding=embedding, settings=SETTINGS)
    assert other_end == (outcome, evidence), "a pair is meant if one of its ends is"
    nothing = answer(Relation.REMOVED, first, second, (), (), embedding=embedding, settings=SETTINGS)
    assert nothing == (Abstention(AbstentionReason.NOTHING_GROUNDED), Evidence((), ()))


def test_the_static_arm_and_the_agent_give_the_same_answer():
    maps = {"first": objects((0, 0), (5, 0)), "second": objects((0, 0.2), (5, 3))}
    context = SimpleNamespace(map=maps.__getitem__, noun=embedding, settings=SETTINGS, privileged_grounding=False)
    expected, evidence = predict_two_visits(Query("Chair", Relation.MOVED), context)
    assert (expected, evidence.pairs) == (Answer(5.0, 3.0), ((0, 0), (1, 1)))
    driver = ReactAgent(context)
    driver.map_1, driver.map_2 = maps.values()
    assert driver.decide(Query("Chair", Relation.MOVED)) == expected
