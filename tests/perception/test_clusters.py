"""The map of a visit, and the one map of two visits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.perception.clusters import Detection, clusters
from ovman.perception.maps import build_map
from ovman.perception.records import Detected

RADIUS_M = 0.6


def seen(view: int, x: float, z: float, y: float = 1.0, feature: tuple[float, ...] = (1.0, 0.0)) -> Detection:
    return Detection(view, np.array([x, y, z]), np.array(feature))


coordinates = st.floats(-4, 4)
tours = st.lists(st.tuples(st.integers(0, 23), coordinates, coordinates, st.floats(0, 2)), max_size=40).map(
    lambda items: [seen(view, x, z, y) for view, x, z, y in sorted(items)]
)


@given(tours)
def test_every_detection_is_in_one_cluster_and_height_does_not_matter(detections):
    found = clusters(detections, RADIUS_M)
    tracks = sorted(tuple(point) for c in found for point in c.track)
    assert tracks == sorted((d.point[0], d.point[2]) for d in detections)
    flat = clusters([Detection(d.view, d.point * [1, 0, 1], d.feature) for d in detections], RADIUS_M)
    assert [c.position.tolist() for c in flat] == [c.position.tolist() for c in found]
    assert sorted(k for c in found for k in c.members.tolist()) == list(range(len(detections)))
    for c in found:
        assert [detections[k].point[[0, 2]].tolist() for k in c.members] == c.track.tolist()
        assert (np.diff(c.views) >= 0).all() and c.last_seen == c.views[-1]
        assert c.position == pytest.approx(np.median(c.track, axis=0))


def test_what_moves_far_between_two_views_falls_into_pieces():
    found = clusters([seen(v, 0.5 * v, 0.0) for v in range(6)], RADIUS_M)
    assert len(found) > 1
    assert found[-1].last_seen == 5


def test_a_feature_is_the_mean_direction_of_its_views():
    (found,) = clusters([seen(0, 0, 0, feature=(1.0, 0.0)), seen(1, 0, 0, feature=(0.0, 1.0))], RADIUS_M)
    assert found.feature == pytest.approx([0.5**0.5, 0.5**0.5])


whole_tours = st.lists(st.tuples(st.integers(0, 23), coordinates, coordinates), max_size=20).map(lambda rows: tour(sorted(rows)))


def tour(rows: list[tuple[int, float, float]]) -> Detected:
    count = len(rows)
    masks = lambda: np.ones((count, 1, 1), bool)  # noqa: E731
    point = np.array([(x, 1.0, z) for _, x, z in rows]).reshape(-1, 3)
    feature = np.tile(np.float32([1, 0]), (count, 1))
    return Detected(np.array([v for v, *_ in rows], int), point, feature, np.ones(count, int), np.ones(count), masks, "")


def content(clusters) -> list:
    return [(c.position.tolist(), c.track.tolist(), c.members.tolist()) for c in clusters]


@given(whole_tours, whole_tours)
def test_detections_are_numbered_through_both_tours_and_each_is_in_one_cluster(first, second):
    points = np.concatenate([first.point, second.point])[:, [0, 2]]
    found = build_map([first, second], RADIUS_M)
    assert sorted(k for c in found for k in c.members.tolist()) == list(range(len(first) + len(second)))
    for c in found:
        assert np.array_equal(points[c.members], c.track)
        assert (np.diff(c.members) > 0).all() and (np.diff(c.views) >= 0).all()
        later = c.members >= len(first)
        assert not len(first) or (c.views[later] > first.view.max()).all()


@given(whole_tours)
def test_a_tour_that_shows_nothing_adds_nothing_and_the_same_tour_again_stays_within_its_clusters(seen):
    nothing = tour([])
    alone = content(build_map([seen], RADIUS_M))
    assert content(build_map([seen, nothing], RADIUS_M)) == content(build_map([nothing, seen], RADIUS_M)) == alone


def test_what_stays_joins_its_cluster_and_what_moves_begins_one():
    before, after = tour([(0, 0.0, 0.0), (1, 2.0, 0.0)]), tour([(0, 0.1, 0.0), (1, 2.0, 2.0)])
    found = build_map([before, after], RADIUS_M)
    assert [c.members.tolist() for c in found] == [[0, 2], [1], [3]]
