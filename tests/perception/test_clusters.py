"""The map of a visit, and the one map of two visits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.perception.clusters import Detection, clusters
from ovman.perception.maps import build_map
from ovman.perception.records import Detected

RADIUS_M = 0.6


coordinates = st.floats(-4, 4)
places = st.tuples(coordinates, coordinates) | st.tuples(*2 * [st.integers(-1, 1).map(lambda step: step * RADIUS_M)])
tours = st.lists(
    st.tuples(st.integers(0, 23), places, st.floats(0, 2), st.sampled_from([(1.0, 0.0), (0.6, 0.8)])), max_size=25
).map(lambda items: [Detection(v, np.array([x, y, z]), np.array(feature)) for v, (x, z), y, feature in sorted(items)])


def join_nearest(points: list[tuple[float, float]]) -> list[list[int]]:
    """Members by definition: each point joins the nearest cluster whose median is within the radius, or begins one."""
    found: list[list[int]] = []
    for number, here in enumerate(points):
        gaps = [np.linalg.norm(np.median([points[k] for k in members], axis=0) - here) for members in found]
        nearest = int(np.argmin(gaps)) if gaps and min(gaps) <= RADIUS_M else len(found)
        found[nearest : nearest + 1] = [[*(found[nearest] if nearest < len(found) else ()), number]]
    return found


@settings(max_examples=100)
@given(tours)
def test_clusters_are_those_of_the_definition_whatever_the_heights(detections):
    found = clusters(detections, RADIUS_M)
    points = [(d.point[0], d.point[2]) for d in detections]
    assert [c.members.tolist() for c in found] == join_nearest(points)
    for c in found:
        members = [detections[k] for k in c.members]
        assert c.track.tolist() == [[*points[k]] for k in c.members] and c.views.tolist() == [d.view for d in members]
        assert c.position == pytest.approx(np.median(c.track, axis=0)) and c.last_seen == c.views[-1]
        total = np.sum([d.feature for d in members], axis=0)
        assert c.feature == pytest.approx(total / np.linalg.norm(total))


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
