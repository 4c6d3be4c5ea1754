"""REACT's clusters and matching: properties of the output, and small cases by hand."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.react.agent import Instances, class_features, cluster_instances, find_instances, match_instances
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS
from ovman.perception.clusters import Cluster
from ovman.perception.object_map import ObjectMap
from tests.arms import CONFIG

APPEARANCE = CONFIG.react.appearance
LOOKS = np.eye(4)


def seen(*things: tuple[float, float, int], views: int = 1) -> Instances:
    """Instances by x, z and look; the class is that of the look's half."""
    of = np.array([look for *_, look in things], np.int64)
    return Instances(np.array([thing[:2] for thing in things], float).reshape(-1, 2), LOOKS[of], of // 2, np.full(len(of), views))


places = st.tuples(st.integers(-8, 8), st.integers(-8, 8)).map(lambda at: (at[0] / 2, at[1] / 2))
homes = st.lists(st.tuples(places, st.integers(0, 3)), max_size=7, unique_by=lambda one: one[0]).map(
    lambda found: seen(*((*place, look) for place, look in found))
)


def reordered(visit: Instances, order) -> Instances:
    of = np.array(order, np.int64)
    return Instances(visit.place[of], visit.feature[of], visit.kind[of], visit.views[of])


@given(homes)
def test_a_home_that_is_as_it_was_is_all_matched_where_it_stands(home):
    found = match_instances(home, home, APPEARANCE)
    assert found.pairs == tuple((i, i) for i in range(len(home))) and not found.unmatched_1 and not found.unmatched_2


@given(homes, homes)
def test_every_instance_is_matched_once_or_absent_or_new(first, second):
    found = match_instances(first, second, APPEARANCE)
    assert sorted([i for i, _ in found.pairs] + list(found.unmatched_1)) == list(range(len(first)))
    assert sorted([j for _, j in found.pairs] + list(found.unmatched_2)) == list(range(len(second)))
    for look in range(len(LOOKS)):
        old, new = (int(np.count_nonzero(visit.feature[:, look])) for visit in (first, second))
        same = [(i, j) for i, j in found.pairs if first.feature[i, look]]
        assert len(same) == min(old, new) and all(second.feature[j, look] for _, j in same)


@given(homes, homes, st.randoms(use_true_random=False))
def test_the_order_of_instances_is_of_no_consequence(first, second, random):
    orders = [random.sample(range(len(visit)), len(visit)) for visit in (first, second)]
    again = match_instances(*(reordered(visit, order) for visit, order in zip((first, second), orders, strict=True)), APPEARANCE)
    assert sorted((orders[0][i], orders[1][j]) for i, j in again.pairs) == list(match_instances(first, second, APPEARANCE).pairs)


@given(st.lists(places, min_size=1, max_size=4, unique=True), st.lists(places, min_size=1, max_size=4, unique=True))
def test_alike_instances_travel_least_in_all(old, new):
    first, second = (seen(*((*place, 0) for place in found)) for found in (old, new))
    pairs = match_instances(first, second, APPEARANCE).pairs
    few, many = sorted((old, new), key=len)
    least = min(
        sum(np.hypot(a[0] - b[0], a[1] - b[1]) for a, b in zip(few, chosen, strict=True))
        for chosen in itertools.permutations(many, len(few))
    )
    travelled = sum(float(np.hypot(*(first.place[i] - second.place[j]))) for i, j in pairs)
    assert len(pairs) == len(few) and travelled == pytest.approx(least)


def test_an_object_that_moved_is_matched_by_its_looks_however_far_it_went():
    before, now = seen((0, 0, 0), (1, 0, 1)), seen((0, 0, 1), (50, 0, 0))
    assert match_instances(before, now, APPEARANCE).pairs == ((0, 1), (1, 0))


def test_another_class_is_never_matched_however_alike():
    first, second = seen((0, 0, 0)), seen((0, 0, 0))
    other = Instances(second.place, second.feature, second.kind + 1, second.views)
    found = match_instances(first, other, APPEARANCE)
    assert (found.pairs, found.unmatched_1, found.unmatched_2) == ((), (0,), (0,))


def turned(degrees: float, views: int = 1) -> Instances:
    angle = np.radians(degrees)
    return Instances(np.zeros((1, 2)), np.array([[np.cos(angle), np.sin(angle)]]), np.zeros(1, np.int64), np.array([views]))


def joined(*visits: Instances) -> Instances:
    return Instances(*(np.concatenate([getattr(one, name) for one in visits]) for name in Instances.__slots__))


def test_looks_up_to_the_distance_are_alike():
    apart = 2 * np.degrees(np.arcsin(APPEARANCE / 2))
    assert len(match_instances(turned(0.0), turned(apart - 0.1), APPEARANCE).pairs) == 1
    assert not match_instances(turned(0.0), turned(apart + 0.1), APPEARANCE).pairs


def test_a_cluster_looks_like_the_mean_over_its_views():
    first = joined(turned(0.0, views=3), turned(10.0, views=1))
    (cluster,) = cluster_instances(first, seen(), APPEARANCE)
    assert cluster.views == 4 and cluster.first == (0, 1) and cluster.second == ()
    assert np.allclose(cluster.feature, 0.75 * first.feature[0] + 0.25 * first.feature[1])


def test_the_nearest_looks_are_one_cluster_before_others():
    # 10 and 19 degrees are one at 14.5, which is too far from 0 degrees. From 0 and 10 on, all three would have become one.
    found = cluster_instances(
        joined(turned(0.0), turned(10.0), turned(19.0), turned(40.0)), joined(*(turned(d) for d in (41.0,))), APPEARANCE
    )
    assert sorted((one.first, one.second) for one in found) == [((0,), ()), ((1, 2), ()), ((3,), (0,))]


def test_the_class_of_an_object_is_the_nearest_name():
    names = [noun(category) for category in SYNONYMS]
    embedding = dict(zip(names, np.eye(len(names)), strict=True))
    chair = embedding["chair"] * 0.8 + embedding["mug"] * 0.6
    track = np.array([[1.0, 2.0], [1.2, 2.0]])
    found = find_instances(ObjectMap.of([Cluster(track[0], chair, track, np.arange(2))]), class_features(embedding.__getitem__))
    assert [names[kind] for kind in found.kind] == ["chair"] and found.views.tolist() == [2]
    assert len(find_instances(ObjectMap.of(()), class_features(embedding.__getitem__))) == 0
