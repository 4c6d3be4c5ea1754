"""DualMap's local map, the life of its objects, and their clouds: properties and the published keyframes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.dualmap.cloud import Cloud, find_largest_clusters
from ovman.agents.dualmap.local_map import (
    LocalMap,
    MapObject,
    Observed,
    Sight,
    find_common_pair,
    has_converged,
    is_stable,
    match_objects,
    split,
)
from ovman.agents.dualmap.maps import sight_of
from ovman.agents.dualmap.observations import FrameObject
from tests.agents.dualmap.boxworld import CONSTANTS, DENSE, FEATURES, TEN, Box, feature, observation, walk

LOCAL, LIFE = CONSTANTS.local_map, CONSTANTS.local_map.life


@pytest.mark.parametrize(
    ("classes", "confidences", "stable"),
    [
        ([3] * 7, [0.9] * 7, False),
        ([3] * 8, [0.9] * 8, True),
        # Unsure observations of several classes leave the filter undecided, so that the majority alone counts.
        ([0, 1, 2] * 4, [0.1] * 12, False),
        ([0, 1, 2] * 3 + [0, 0, 3], [0.1] * 12, True),
        # Without a majority the filter counts, once it has come to rest.
        ([*range(10), 9, 9, 10, 11, 9], [0.3] * 9 + [0.95] * 3 + [0.07, 0.07, 0.95], True),
        ([*range(9)], [0.3] * 9, False),
    ],
)
def test_an_object_is_stable_after_eight_observations_with_a_majority_of_a_third_or_a_filter_at_rest(
    classes, confidences, stable
):
    assert is_stable(classes, confidences, 16, LIFE) is stable


def test_a_filter_that_has_just_changed_its_mind_has_not_converged():
    assert not has_converged([1, 2, 2], [0.9] * 3, 16, LIFE)
    assert not has_converged([1, 1], [0.99, 0.99], 16, LIFE)
    assert has_converged([1, 2, 2, 2, 2], [0.9] * 5, 16, LIFE)


def mapped(frames: Sequence[Sequence[FrameObject]], run: int = 0) -> LocalMap:
    local = LocalMap(FEATURES, LOCAL, np.random.default_rng(run))
    for seen in frames:
        local.observe([sight_of(one, run) for one in seen])
    return local


def sight(points: np.ndarray, look: np.ndarray, class_id: int = 0) -> Sight:
    return Sight(class_id, 0.8, look, Cloud.of(points))


def thing_of(*sights: Sight, uid: int = 0, keyframes: Sequence[int] = range(99)) -> MapObject:
    return MapObject.of(uid, [Observed(one, keyframes[k], k) for k, one in enumerate(sights)], LOCAL)


def sheet(points: int) -> np.ndarray:
    """Points of a box of 1 m by 0.2 m by 1 m, no two of them as near as clouds share points."""
    places = np.stack(np.meshgrid(np.arange(20), np.arange(4), np.arange(20)), axis=-1).reshape(-1, 3) * 0.05
    return np.random.default_rng(0).permutation(places)[:points]


@pytest.mark.parametrize(("count", "stays"), [(7, False), (8, True)])
def test_an_object_that_is_not_stable_is_forgotten_after_fifteen_keyframes_without_it(count: int, stays: bool):
    local, one = mapped([]), sight(sheet(50), feature(0))
    for _ in range(count - 1):
        local.observe([one])
    for _ in range(15):
        local.observe([])
    local.observe([one])
    for missed in range(1, 40):
        local.observe([])
        assert len(local.objects) == (stays or missed <= 15)


def test_a_finished_map_has_the_objects_that_would_stay():
    """On a short walk some objects are seen too rarely."""
    local = mapped(walk(TEN, DENSE[:30]))
    finished = local.finish()
    for _ in range(16):
        local.observe([])
    assert [thing.uid for thing in finished] == sorted(thing.uid for thing in local.objects) and 0 < len(finished) < 10


def test_ten_boxes_on_a_dense_walk_are_ten_objects_at_their_places_whatever_the_order_within_keyframes():
    frames = walk(TEN, DENSE)
    shuffled = [np.random.default_rng(k).permutation(np.array(seen, object)) for k, seen in enumerate(frames)]
    objects, others = (sorted(mapped(one).finish(), key=lambda thing: thing.class_id) for one in (frames, shuffled))
    assert [thing.class_id for thing in objects] == list(range(10))
    for thing, other in zip(objects, others, strict=True):
        x, _, z = TEN[thing.class_id].centre
        assert np.hypot(*(thing.position - [x, z])) <= 0.1
        assert thing.feature == pytest.approx(feature(thing.class_id), abs=1e-6)
        assert np.array_equal(thing.position, other.position) and len(thing.seen) == len(other.seen)


@pytest.mark.parametrize(
    ("shared", "cosine", "same"), [(0.10, 1, False), (0.20, 1, False), (0.30, 1, True), (1, 0.15, False), (1, 0.25, True)]
)
def test_one_of_points_and_look_and_more_than_a_fifth_of_the_other_make_an_observation_an_objects(shared, cosine, same):
    points, look = sheet(1000), cosine * feature(0) + np.sqrt(1 - cosine**2) * feature(1)
    thing, apart = thing_of(sight(points, feature(0))), points.copy()
    apart[round(shared * len(points)) :] += [0.025, 0.025, 0.025]
    assert match_objects([sight(apart, look)], [thing], LOCAL) == ([0] if same else [None])


@given(st.integers(0, 2**32 - 1))
def test_the_first_of_the_most_similar_objects_is_matched(seed: int):
    rng = np.random.default_rng(seed)

    def fresh() -> Sight:
        look = feature(0) + rng.normal(0, 0.2, FEATURES)
        return sight(rng.uniform(0, 0.15, (60, 3)) + rng.uniform(0, 0.1, 3), look / np.linalg.norm(look))

    objects = [thing_of(*(fresh() for _ in range(int(rng.integers(1, 5))))) for _ in range(6)]
    objects += objects[:2]
    sights = [fresh() for _ in range(4)]
    for one, found in zip(sights, match_objects(sights, objects, LOCAL), strict=True):
        similarity = []
        for thing in objects:
            low, high = (
                limit(one.cloud.box.reshape(2, 3)[k], thing.box.reshape(2, 3)[k])
                for k, limit in enumerate((np.maximum, np.minimum))
            )
            both = np.prod(np.maximum(high - low, 0.0))
            union = sum(np.prod(box[3:] - box[:3]) for box in (one.cloud.box, thing.box)) - both
            gaps = np.linalg.norm(one.cloud.columns.T[:, None] - thing.columns.T[None], axis=2).min(axis=1)
            near = (gaps <= LOCAL.near_m).mean() if both / union >= LOCAL.least_iou else 0.0
            similarity.append(float(one.feature @ thing.feature) + near)
        best = int(np.argmax(similarity))
        assert found == (best if similarity[best] > LOCAL.match else None)
    assert match_objects(sights, [], LOCAL) == [None] * 4


@given(st.integers(0, 2**32 - 1), st.integers(1, 300))
def test_a_thinned_cloud_has_the_mean_of_each_voxel_in_the_order_of_their_first_points(seed: int, count: int):
    points = np.random.default_rng(seed).uniform(-1, 1, (count, 3)) * [0.1, 0.2, 0.3]
    voxels: dict[tuple[float, ...], list[np.ndarray]] = {}
    for cell, point in zip(np.floor((points - points.min(axis=0)) / 0.05 + 0.5), points, strict=True):
        voxels.setdefault(tuple(cell), []).append(point)
    means = np.array([np.mean(inside, axis=0) for inside in voxels.values()])
    assert pytest.approx(means) == Cloud.of(points).thin(0.05).columns.T


def test_a_cloud_is_thinned_at_every_third_observation_the_feature_is_the_mean_and_the_class_the_commonest():
    sizes = [thing_of(*[sight(sheet(200), feature(0))] * count).columns.shape[1] for count in range(1, 7)]
    assert sizes == [200, 400, 200, 400, 600, 200]
    thing = thing_of(*(sight(sheet(100), feature(k), k) for k in (4, 2, 2, 4, 2)))
    assert thing.class_id == 2
    assert thing.feature == pytest.approx((2 * feature(4) + 3 * feature(2)) / np.sqrt(13))


def test_two_classes_in_more_than_six_common_keyframes_are_two_objects():
    box = Box((0, 0.5, 0), (1, 1, 1), class_id=0)
    rng, eye = np.random.default_rng(0), np.array([3.0, 1.0, 3.0])

    def both() -> list[Sight]:
        one = sight_of(observation(box, eye, rng, points=600), 0)
        return [replace(one, class_id=k, feature=0.8 * feature(0) + 0.6 * feature(1)) for k in (0, 1)]

    local = mapped([])
    local.observe(both()[:1])
    counts = []
    for _ in range(7):
        local.observe(both())
        counts.append(len(local.objects))
    assert counts == [1] * 6 + [2]
    assert sorted((thing.class_id, len(thing.seen)) for thing in local.objects) == [(0, 8), (1, 7)]


def test_the_commoner_of_two_classes_of_the_last_keyframes_keeps_what_was_seen_as_a_third():
    rows = [(keyframe, k) for keyframe in range(20) for k in ((0, 1) if keyframe < 12 else (0,))]
    thing = thing_of(*(sight(sheet(50), feature(0), k) for _, k in rows), keyframes=[keyframe for keyframe, _ in rows])
    for since, pair in ((0, (0, 1, 12)), (10, (0, 1, 2)), (12, None)):
        assert find_common_pair(thing, since) == pair
    whole = thing_of(*(sight(sheet(50), feature(k), k) for k in (0, 1, 1, 2, 1, 0)), uid=7)
    parts = [(one.uid, one.class_id, [seen.number for seen in one.seen]) for one in split(whole, 0, 1, 8, LOCAL)]
    assert parts == [(7, 1, [1, 2, 3, 4]), (8, 0, [0, 5])]


def by_all_pairs(points: np.ndarray, radius_m: float, least: int) -> np.ndarray:
    """Labels of DBSCAN as it is defined, clusters in the order of their first core points; -1 is noise."""
    near = ((points[:, None] - points[None]) ** 2).sum(axis=2) <= radius_m * radius_m
    core = near.sum(axis=1) >= least
    labels, clusters = np.full(len(points), -1), 0
    for start in np.flatnonzero(core):
        if labels[start] >= 0:
            continue
        labels[start], waiting = clusters, [start]
        while waiting:
            for j in np.flatnonzero(near[waiting.pop()] & (labels < 0)):
                labels[j] = clusters
                if core[j]:
                    waiting.append(j)
        clusters += 1
    return labels


@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.integers(0, 90), max_size=3),
    st.integers(1, 12),
    st.tuples(*3 * [st.sampled_from([0.0, 0.05, 0.4, 1.2])]),
)
def test_the_largest_clusters_are_those_of_the_definition(seed, counts, least, extent):
    rng = np.random.default_rng(seed)
    clouds, wanted = [], []
    for count in counts:
        blobs = rng.random((4, 3))[rng.integers(0, 4, count)]
        clouds.append((blobs + 0.15 * rng.standard_normal((count, 3))) * extent)
        labels = by_all_pairs(clouds[-1], 0.1, least) if count else np.zeros(0)
        found = labels[labels >= 0].astype(int)
        wanted.append(np.flatnonzero(labels == np.bincount(found).argmax()).tolist() if len(found) else [])
    assert [found.tolist() for found in find_largest_clusters(clouds, 0.1, least)] == wanted
