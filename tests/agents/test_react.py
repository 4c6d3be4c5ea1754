"""REACT: clusters and matching as properties, and the answers from its output by relation."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.interface import Abstention, AbstentionReason, Answer, Evidence, Query, Relation
from ovman.agents.react.agent import ReactAgent, answer, cluster_instances, decide_relation, match_instances, predict_two_visits
from ovman.agents.reference.association import Association
from ovman.perception.clusters import ObjectMap
from ovman.settings.settings import settings_of_arm
from tests.arms import CONFIG

APPEARANCE = CONFIG.react.appearance
LOOKS = np.eye(4)
CLASSES = np.array([[1, 1, 0, 0], [0, 0, 1, 1]]) / np.sqrt(2)


def objects(places, features=None, views=None, last_seen=None) -> ObjectMap:
    """Objects by places and features, chairs if there are none."""
    features = np.tile(CHAIR, (len(places), 1)) if features is None else features
    p = np.array(places, float).reshape(-1, 2)
    tracks = tuple(np.tile(place, (count, 1)) for place, count in zip(p, views or [1] * len(p), strict=True))
    return ObjectMap(p, features, tracks, last_seen or tuple(range(len(p))))


CHAIR, LAMP = np.eye(3)[:2]
places = st.tuples(st.integers(-8, 8), st.integers(-8, 8)).map(lambda at: (at[0] / 2, at[1] / 2))
homes = st.lists(st.tuples(places, st.integers(0, 3)), max_size=7, unique_by=lambda one: one[0]).map(
    lambda found: objects([place for place, _ in found], LOOKS[np.array([look for _, look in found], int)])
)


@given(homes, homes, st.randoms(use_true_random=False))
def test_the_order_of_instances_is_of_no_consequence(first, second, random):
    orders = [random.sample(range(len(visit)), len(visit)) for visit in (first, second)]
    shuffled = (objects(visit.p[order], visit.f[order]) for visit, order in zip((first, second), orders, strict=True))
    again = match_instances(*shuffled, CLASSES, APPEARANCE).pairs
    assert sorted((orders[0][i], orders[1][j]) for i, j in again) == [*match_instances(first, second, CLASSES, APPEARANCE).pairs]


@given(homes, homes)
def test_every_instance_is_matched_once_or_absent_or_new_and_alike_ones_travel_least_in_all(first, second):
    found = match_instances(first, second, CLASSES, APPEARANCE)
    assert sorted([i for i, _ in found.pairs] + list(found.unmatched_1)) == list(range(len(first)))
    assert sorted([j for _, j in found.pairs] + list(found.unmatched_2)) == list(range(len(second)))
    for look in range(len(LOOKS)):
        few, many = sorted((visit.p[visit.f[:, look] > 0].tolist() for visit in (first, second)), key=len)
        same = [(i, j) for i, j in found.pairs if first.f[i, look]]
        assert len(same) == len(few) and all(second.f[j, look] for _, j in same)
        least = min(sum(map(math.dist, few, chosen)) for chosen in itertools.permutations(many, len(few)))
        assert sum(math.dist(first.p[i], second.p[j]) for i, j in same) == pytest.approx(least)


def turned(*degrees: float, views=None) -> ObjectMap:
    angles = np.radians(degrees)
    return objects([(0, 0)] * len(degrees), np.column_stack([np.cos(angles), np.sin(angles)]), views)


AXES, ONE_CLASS = np.eye(2), np.eye(2)[:1]


def test_looks_up_to_the_distance_are_alike_within_a_class_alone():
    apart = 2 * np.degrees(np.arcsin(APPEARANCE / 2))
    for degrees, pairs in ((apart - 0.1, ((0, 0),)), (apart + 0.1, ())):
        assert match_instances(turned(0.0), turned(degrees), ONE_CLASS, APPEARANCE).pairs == pairs
    for degrees, pairs in ((44.5, ((0, 0),)), (46.0, ())):
        assert match_instances(turned(44.0), turned(degrees), AXES, APPEARANCE).pairs == pairs


def test_a_cluster_looks_like_the_mean_over_its_views():
    first = turned(0.0, 10.0, views=[3, 1])
    (cluster,) = cluster_instances(first, turned(), ONE_CLASS, APPEARANCE)
    assert cluster.views == 4 and cluster.first == (0, 1) and cluster.second == ()
    assert np.allclose(cluster.feature, 0.75 * first.f[0] + 0.25 * first.f[1])


def test_the_nearest_looks_are_one_cluster_before_others():
    # 10 and 19 degrees are one at 14.5, which is too far from 0 degrees. From 0 and 10 on, all three would have become one.
    found = cluster_instances(turned(0.0, 10.0, 19.0, 40.0), turned(41.0), ONE_CLASS, 0.25)
    assert sorted((one.first, one.second) for one in found) == [((0,), ()), ((1, 2), ()), ((3,), (0,))]


SETTINGS = settings_of_arm(CONFIG, "react_two_visits")
"""Those that the arm lists: another one raises an AttributeError."""
TAU_M = SETTINGS.admissibility.tau_m

FIRST, SECOND = objects([(0, 0), (5, 0), (0, 6)]), objects([(0, 0.2), (9, 0), (3, 3)], last_seen=(7, 5, 6))
STAYED, WENT = (0, 0), (1, 1)
"""Pairs: the first object stays, the second travels 4 m. The third is absent, or new."""


@pytest.mark.parametrize(
    ("relation", "pairs", "is_absent", "is_new", "expected"),
    [
        (Relation.MOVED, (STAYED, WENT), True, True, (9, 0)),
        (Relation.MOVED, (STAYED,), True, True, (3, 3)),
        (Relation.MOVED, (STAYED,), True, False, AbstentionReason.DISPLACEMENT_BELOW_TAU),
        (Relation.MOVED, (), True, False, AbstentionReason.NO_CANDIDATE),
        (Relation.FORMER, (STAYED, WENT), True, True, (5, 0)),
        (Relation.FORMER, (STAYED,), True, True, (0, 6)),
        (Relation.FORMER, (STAYED,), False, True, AbstentionReason.DISPLACEMENT_BELOW_TAU),
        (Relation.STABLE, (STAYED, WENT), True, True, (0, 0.2)),
        (Relation.STABLE, (WENT,), True, True, AbstentionReason.DISPLACEMENT_ABOVE_TAU),
        (Relation.APPEARED, (STAYED, WENT), True, True, (3, 3)),
        (Relation.APPEARED, (STAYED,), True, False, AbstentionReason.NO_CANDIDATE),
        (Relation.REMOVED, (STAYED, WENT), True, True, (0, 6)),
        (Relation.REMOVED, (STAYED,), False, True, AbstentionReason.NO_CANDIDATE),
        (Relation.MOVING, (STAYED, WENT), True, True, (3, 3)),
        (Relation.MOVING, (STAYED,), True, False, AbstentionReason.NO_CANDIDATE),
    ],
)
def test_each_relation_is_read_off_the_output(relation, pairs, is_absent, is_new, expected):
    found = Association(pairs, (2,) * is_absent, (2,) * is_new)
    outcome = Abstention(expected) if isinstance(expected, AbstentionReason) else Answer(*map(float, expected))
    assert decide_relation(relation, FIRST, SECOND, found, SETTINGS) == outcome


@pytest.mark.parametrize("gone_m", [TAU_M - 0.01, TAU_M])
def test_a_matched_one_has_moved_from_tau_on(gone_m):
    first, second, found = objects([(0, 0)]), objects([(gone_m, 0)]), Association(((0, 0),), (), ())
    moved = gone_m >= TAU_M
    assert isinstance(decide_relation(Relation.MOVED, first, second, found, SETTINGS), Answer) is moved
    assert isinstance(decide_relation(Relation.STABLE, first, second, found, SETTINGS), Answer) is not moved
    assert isinstance(decide_relation(Relation.MOVING, first, second, found, SETTINGS), Answer) is moved


def embedding(phrase: str) -> np.ndarray:
    return {"chair": CHAIR, "floor lamp": LAMP}.get(phrase, np.eye(3)[2])


def test_the_evidence_is_what_the_noun_means_and_what_was_taken_for_the_same():
    first, second = objects([(0, 0), (5, 0)]), objects([(0, 0.2)])
    outcome, evidence = answer(Relation.REMOVED, first, second, (0, 1), (0,), embedding=embedding, settings=SETTINGS)
    assert (outcome, evidence) == (Answer(5.0, 0.0), Evidence((0, 1), (0,), ((0, 0),)))
    other_end = answer(Relation.REMOVED, first, second, (1,), (0,), embedding=embedding, settings=SETTINGS)
    assert other_end == (outcome, evidence), "a pair is meant if one of its ends is"
    nothing = answer(Relation.REMOVED, first, second, (), (), embedding=embedding, settings=SETTINGS)
    assert nothing == (Abstention(AbstentionReason.NOTHING_GROUNDED), Evidence((), ()))


@pytest.mark.parametrize(
    ("relation", "place"), [(Relation.MOVED, (5.0, 3.0)), (Relation.MOVING, (5.0, 3.0)), (Relation.STABLE, (0.0, 0.2))]
)
def test_the_static_arm_and_the_agent_give_the_same_answer(relation, place):
    maps = {"first": objects([(0, 0), (5, 0)]), "second": objects([(0, 0.2), (5, 3)])}
    context = SimpleNamespace(map=maps.__getitem__, noun=embedding, settings=SETTINGS, privileged_grounding=False)
    expected, evidence = predict_two_visits(Query("Chair", relation), context)
    assert (expected, evidence.pairs) == (Answer(*place), ((0, 0), (1, 1)))
    context.settings = settings_of_arm(CONFIG, "react_two_visits_embodied")
    driver = ReactAgent(context)
    driver.map_1, driver.map_2 = maps.values()
    assert driver.decide(Query("Chair", relation)) == expected
