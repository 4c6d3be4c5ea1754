"""DualMap's local map, the life of its objects, and their clouds: properties and the published keyframes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.agents.dualmap.cloud import Cloud, box_iou, largest_cluster, thin
from ovman.agents.dualmap.local_map import (
    LocalMap,
    MapObject,
    Phase,
    RunObservation,
    Stage,
    advance,
    find_common_pair,
    has_converged,
    is_stable,
    match_objects,
    split,
)
from ovman.agents.dualmap.observations import ObjectObservation
from tests.agents.dualmap.boxworld import CONSTANTS, DENSE, FEATURES, TEN, Box, feature, observation, walk

LIFE = CONSTANTS.local_map.life


def life(stable: bool, unseen: int) -> list[Phase]:
    """The phases of an object through so many keyframes after the one that showed it last."""
    stage, phases = Stage(), []
    for missed in range(1, unseen + 1):
        stage = advance(stage, missed, stable, LIFE)
        phases.append(stage.phase)
        if stage.phase in (Phase.GONE, Phase.SETTLED):
            break
    return phases


def test_an_unstable_object_is_updated_for_ten_keyframes_pending_for_five_and_then_gone():
    assert life(stable=False, unseen=40) == [Phase.UPDATING] * 10 + [Phase.PENDING] * 5 + [Phase.GONE]


def test_a_stable_object_waits_for_five_keyframes_and_has_settled():
    assert life(stable=True, unseen=40) == [Phase.UPDATING] * 10 + [Phase.WAITING] * 5 + [Phase.SETTLED]


@pytest.mark.parametrize("phase", [Phase.PENDING, Phase.WAITING, Phase.SETTLED])
def test_what_is_seen_again_is_updated_again_and_its_time_begins_anew(phase: Phase):
    assert advance(Stage(phase, 4), 0, True, LIFE) == Stage(Phase.UPDATING, 0)


def test_seven_observations_are_not_enough_and_eight_of_one_class_are():
    assert not is_stable([3] * 7, [0.9] * 7, 16, LIFE)
    assert is_stable([3] * 8, [0.9] * 8, 16, LIFE)


def test_the_majority_is_more_than_a_third():
    third, more = [0, 1, 2] * 4, [0, 1, 2] * 3 + [0, 0, 3]
    # Unsure observations of several classes leave the filter undecided, so that the majority alone counts.
    assert not is_stable(third, [0.1] * 12, 16, LIFE)
    assert is_stable(more, [0.1] * 12, 16, LIFE)


def test_without_a_majority_a_filter_that_has_come_to_rest_makes_an_object_stable():
    classes = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9]
    sure = [0.3] * 9 + [0.95] * 3
    assert classes.count(9) * 3 <= len(classes)
    assert has_converged(classes + [9], sure + [0.95], 16, LIFE)
    assert is_stable(classes + [10, 11, 9], sure + [0.07, 0.07, 0.95], 16, LIFE)
    assert not is_stable(classes[:9], sure[:9], 16, LIFE)


def test_a_filter_that_has_just_changed_its_mind_has_not_converged():
    assert not has_converged([1, 2, 2], [0.9] * 3, 16, LIFE)
    assert not has_converged([1, 1], [0.99, 0.99], 16, LIFE)
    assert has_converged([1, 2, 2, 2, 2], [0.9] * 5, 16, LIFE)


LOCAL = CONSTANTS.local_map


def mapped(frames: Sequence[Sequence[ObjectObservation]], run: int = 0, flush: bool = True) -> LocalMap:
    local = LocalMap(FEATURES, LOCAL, np.random.default_rng(run))
    for observations in frames:
        local.observe([RunObservation.of(one, run) for one in observations])
    if flush:
        local.flush()
    return local


def seen(points: np.ndarray, look: np.ndarray, class_id: int = 0) -> RunObservation:
    return RunObservation(class_id, 0.8, look, Cloud.of(points))


def thing_of(*observations: RunObservation, uid: int = 0) -> MapObject:
    return MapObject.of(uid, observations, range(len(observations)), LOCAL)


def sheet(points: int, rng: np.random.Generator) -> np.ndarray:
    """Points of a box of 1 m by 0.2 m by 1 m, no two of them as near as clouds share points."""
    places = np.stack(np.meshgrid(np.arange(20), np.arange(4), np.arange(20)), axis=-1).reshape(-1, 3) * 0.05
    return rng.permutation(places)[:points]


def test_ten_boxes_on_a_dense_walk_are_ten_objects_of_their_class_at_their_places():
    objects = mapped(walk(TEN, DENSE)).objects
    assert sorted(thing.class_id for thing in objects) == list(range(10))
    for thing in objects:
        x, _, z = TEN[thing.class_id].centre
        assert np.hypot(*(thing.position - [x, z])) <= 0.1
        assert thing.feature == pytest.approx(feature(thing.class_id), abs=1e-6)


def test_a_moved_object_is_a_new_entry_and_the_old_one_stays_where_it_was():
    second = [TEN[0].moved(1.0, 1.8), *TEN[1:]]
    objects = mapped([*walk(TEN, DENSE), *walk(second, DENSE, seed=1)]).objects
    places = sorted(tuple(thing.position.round(1).tolist()) for thing in objects if thing.class_id == 0)
    assert places == [(0.0, 0.0), (1.0, 1.8)]
    assert len(objects) == 11


def test_a_map_is_the_same_under_the_same_run_and_another_under_another():
    frames = walk(TEN, DENSE, runs=2)
    once, again, other = mapped(frames), mapped(frames), mapped(frames, run=1)
    assert [thing.uid for thing in once.objects] == [thing.uid for thing in again.objects]
    for a, b in zip(once.objects, again.objects, strict=True):
        assert a.columns.T.tobytes() == b.columns.T.tobytes() and a.feature.tobytes() == b.feature.tobytes()
    assert {tuple(a.position) for a in once.objects}.isdisjoint(tuple(b.position) for b in other.objects)


def test_a_copy_grows_by_itself():
    local = mapped(walk(TEN, DENSE), flush=False)
    before = [thing.columns.T.tobytes() for thing in local.objects]
    copy = local.copy(np.random.default_rng(5))
    for observations in walk([TEN[0].moved(1.0, 1.8), *TEN[1:]], DENSE, seed=1):
        copy.observe([RunObservation.of(one, 0) for one in observations])
    assert len(copy.objects) == 11 and copy.frame == local.frame + len(DENSE)
    assert [thing.columns.T.tobytes() for thing in local.objects] == before


@settings(max_examples=3, derandomize=True, deadline=None)
@given(st.randoms(use_true_random=False))
def test_the_order_of_a_keyframes_observations_does_not_change_which_objects_there_are(random):
    frames = walk(TEN, DENSE)
    shuffled = [random.sample(observations, len(observations)) for observations in frames]

    def content(local: LocalMap) -> list:
        return sorted((*thing.position.tolist(), thing.class_id, len(thing.seen)) for thing in local.objects)

    assert content(mapped(shuffled)) == content(mapped(frames))


@pytest.mark.parametrize(("shared", "same"), [(0.10, False), (0.20, False), (0.30, True), (1.0, True)])
def test_one_look_and_more_than_a_fifth_of_its_points_make_an_observation_an_objects(shared: float, same: bool):
    rng = np.random.default_rng(0)
    points = sheet(1000, rng)
    thing = thing_of(seen(points, feature(0)))
    count = round(shared * len(points))
    apart = points.copy()
    apart[count:] += [0.025, 0.025, 0.025]
    match = match_objects([seen(apart, feature(0))], [thing], LOCAL)
    assert thing.share_near(Cloud.of(apart), LOCAL.near_m) == pytest.approx(shared)
    assert match == ([0] if same else [None])


@pytest.mark.parametrize(("cosine", "same"), [(0.15, False), (0.25, True)])
def test_all_points_and_more_than_a_fifth_of_its_look_do_too(cosine: float, same: bool):
    points = sheet(500, np.random.default_rng(0))
    look = cosine * feature(0) + np.sqrt(1 - cosine**2) * feature(1)
    thing = thing_of(seen(points, feature(0)))
    assert match_objects([seen(points, look)], [thing], LOCAL) == ([0] if same else [None])


def test_the_most_similar_object_is_matched_and_one_elsewhere_never_is():
    points = sheet(500, np.random.default_rng(0))
    less = 0.7 * feature(0) + np.sqrt(1 - 0.49) * feature(1)
    objects = [
        thing_of(seen(points + [5, 0, 0], feature(0))),
        thing_of(seen(points, less)),
        thing_of(seen(points, feature(0))),
    ]
    assert match_objects([seen(points, feature(0)), seen(points, less)], objects, LOCAL) == [2, 1]
    assert match_objects([seen(points + [5, 0, 0], feature(1))], objects, LOCAL) == [None]
    assert match_objects([seen(points, feature(0))], [], LOCAL) == [None]


@given(st.integers(0, 2**32 - 1))
def test_looking_at_the_likeliest_first_finds_what_comparing_with_all_does(seed: int):
    rng = np.random.default_rng(seed)

    def cloud() -> np.ndarray:
        return rng.uniform(0, 0.15, (60, 3)) + rng.uniform(0, 0.1, 3)

    def look() -> np.ndarray:
        vector = feature(0) + rng.normal(0, 0.2, FEATURES)
        return vector / np.linalg.norm(vector)

    objects = [thing_of(*(seen(cloud(), look()) for _ in range(int(rng.integers(1, 5))))) for _ in range(6)]
    fresh = [seen(cloud(), look()) for _ in range(4)]
    for one, found in zip(fresh, match_objects(fresh, objects, LOCAL), strict=True):
        overlap = box_iou(one.cloud.box[None], np.stack([thing.box for thing in objects]))[0] >= LOCAL.least_iou
        near = [
            (np.linalg.norm(one.cloud.columns.T[:, None] - thing.columns.T[None], axis=2).min(axis=1) <= LOCAL.near_m).mean()
            for thing in objects
        ]
        similarity = [
            float(one.feature @ thing.feature) + (share if there else 0.0)
            for thing, share, there in zip(objects, near, overlap, strict=True)
        ]
        best = int(np.argmax(similarity))
        assert found == (best if similarity[best] > LOCAL.match else None)


def test_boxes_that_touch_share_nothing_and_equal_ones_everything():
    boxes = np.array([[0, 0, 0, 1, 1, 1], [1, 0, 0, 2, 1, 1], [0, 0, 0, 1, 1, 2], [0, 0, 0, 1, 0, 1]], float)
    iou = box_iou(boxes, boxes)
    assert np.array_equal(iou, iou.T)
    assert iou[0, 0] == 1 and iou[0, 1] == 0 and iou[0, 2] == 0.5
    assert not iou[3].any(), "a box without volume overlaps nothing, itself included"


@given(st.integers(0, 2**32 - 1), st.integers(1, 300))
def test_a_thinned_cloud_has_a_point_a_voxel_stays_in_its_box_and_is_near_all_it_was(seed: int, count: int):
    points = np.random.default_rng(seed).uniform(-1, 1, (count, 3)) * [0.1, 0.2, 0.3]
    thinned = thin(np.ascontiguousarray(points.T), 0.05).T
    cells = np.floor((points - points.min(axis=0)) / 0.05 + 0.5)
    assert len(thinned) == len(np.unique(cells, axis=0))
    assert (thinned >= points.min(axis=0) - 1e-9).all() and (thinned <= points.max(axis=0) + 1e-9).all()
    assert Cloud.of(thinned).near(points.T, 0.05 * np.sqrt(3)).all()
    assert pytest.approx(points[:1]) == thin(np.ascontiguousarray(points[:1].T), 0.05).T


@given(st.integers(0, 2**32 - 1), st.integers(1, 200), st.floats(0.005, 0.3))
def test_what_is_near_a_cloud_is_what_is_near_one_of_its_points(seed: int, count: int, radius_m: float):
    rng = np.random.default_rng(seed)
    points, asked = rng.uniform(-1, 1, (count, 3)), rng.uniform(-1.2, 1.2, (50, 3))
    gaps = np.linalg.norm(asked[:, None] - points[None], axis=2)
    assert np.array_equal(Cloud.of(points).near(asked.T, radius_m), (gaps <= radius_m).any(axis=1))


def test_a_cloud_is_appended_and_thinned_at_every_third_observation():
    points = sheet(200, np.random.default_rng(0))
    thing = thing_of(seen(points, feature(0)))
    sizes = [thing.columns.shape[1]]
    for frame in range(1, 6):
        thing.add(seen(points, feature(0)), frame, LOCAL)
        sizes.append(thing.columns.shape[1])
    assert sizes == [200, 400, 200, 400, 600, 200]


def test_the_feature_is_the_mean_and_the_class_the_commonest():
    points = sheet(100, np.random.default_rng(0))
    thing = thing_of(*(seen(points, feature(k), k) for k in (4, 2, 2, 4, 2)))
    assert thing.class_id == 2
    assert thing.feature == pytest.approx((2 * feature(4) + 3 * feature(2)) / np.sqrt(13))


def test_two_classes_in_more_than_six_common_keyframes_are_two_objects():
    box = Box((0, 0.5, 0), (1, 1, 1), class_id=0)
    rng, eye = np.random.default_rng(0), np.array([3.0, 1.0, 3.0])
    like = 0.8 * feature(0) + 0.6 * feature(1)

    def both(frame: int) -> list[RunObservation]:
        one = RunObservation.of(observation(box, eye, frame, rng, points=600), 0)
        return [replace(one, class_id=k, feature=like) for k in (0, 1)]

    local = LocalMap(FEATURES, LOCAL, np.random.default_rng(0))
    local.observe([both(0)[0]])
    counts = []
    for frame in range(1, 8):
        local.observe(both(frame))
        counts.append(len(local.objects))
    assert counts == [1] * 6 + [2]
    assert sorted((thing.class_id, len(thing.seen)) for thing in local.objects) == [(0, 8), (1, 7)]


def test_keyframes_before_the_last_ten_do_not_count():
    points = sheet(50, np.random.default_rng(0))
    rows = [(frame, k) for frame in range(20) for k in ((0, 1) if frame < 12 else (0,))]
    thing = MapObject.of(0, [seen(points, feature(0), k) for _, k in rows], [frame for frame, _ in rows], LOCAL)
    assert find_common_pair(thing, since=0) == (0, 1, 12)
    assert find_common_pair(thing, since=10) == (0, 1, 2)
    assert find_common_pair(thing, since=12) is None


def test_what_was_seen_as_a_third_class_stays_with_the_commoner():
    points = sheet(50, np.random.default_rng(0))
    whole = thing_of(*(seen(points, feature(k), k) for k in (0, 1, 1, 2, 1, 0)), uid=7)
    one, other = split(whole, 0, 1, 8, LOCAL)
    assert (one.uid, one.class_id, len(one.seen)) == (7, 1, 4)
    assert (one.frames, other.frames) == ([1, 2, 3, 4], [0, 5])
    assert (other.uid, other.class_id, len(other.seen)) == (8, 0, 2)


def test_a_cloud_of_nothing_is_refused():
    with pytest.raises(ValueError, match="N at least 1"):
        Cloud.of(np.zeros((0, 3)))


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
    st.integers(0, 2**32 - 1), st.integers(1, 90), st.integers(1, 12), st.tuples(*3 * [st.sampled_from([0.0, 0.05, 0.4, 1.2])])
)
def test_the_largest_cluster_is_that_of_the_definition(seed, count, least, extent):
    rng = np.random.default_rng(seed)
    blobs = rng.random((4, 3))[rng.integers(0, 4, count)]
    points = (blobs + 0.15 * rng.standard_normal((count, 3))) * extent
    labels = by_all_pairs(points, 0.1, least)
    wanted = [] if labels.max() < 0 else np.flatnonzero(labels == np.bincount(labels[labels >= 0]).argmax())
    assert largest_cluster(points, 0.1, least).tolist() == list(wanted)


def test_noise_has_no_cluster_and_a_border_point_belongs_to_the_first_that_reaches_it():
    row = np.c_[np.arange(30) * 0.09, np.zeros((30, 2))]
    assert not len(largest_cluster(row, 0.1, 10))
    assert not len(largest_cluster(np.zeros((0, 3)), 0.1, 10))
    left = np.c_[np.linspace(-0.045, 0.0, 10), np.zeros((10, 2))]
    between, right = np.array([[0.1, 0.0, 0.0]]), [0.2, 0.0, 0.0] - left
    assert largest_cluster(np.concatenate([left, between, right]), 0.1 + 1e-9, 10).tolist() == list(range(11))
    assert largest_cluster(np.concatenate([right, between, left]), 0.1 + 1e-9, 10).tolist() == list(range(11))
    assert largest_cluster(np.concatenate([left, right]), 0.1, 10).tolist() == list(range(10))


@pytest.mark.parametrize("axis", range(3))
def test_clusters_do_not_hang_on_the_axis_that_they_lie_along(axis):
    points = np.random.default_rng(0).random((200, 3)) * np.roll([2.0, 0.3, 0.01], axis)
    turned = np.roll(points, 1, axis=1)
    assert largest_cluster(points, 0.1, 5).tolist() == largest_cluster(turned, 0.1, 5).tolist()
