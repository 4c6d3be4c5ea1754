"""One map of two tours."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ovman.perception.detected import Detected, PackedMasks
from ovman.perception.maps import build_map

RADIUS_M = 0.6
coordinates = st.floats(-3, 3)
tours = st.lists(st.tuples(st.integers(0, 23), coordinates, coordinates), max_size=20).map(lambda rows: tour(sorted(rows)))


def tour(rows: list[tuple[int, float, float]]) -> Detected:
    count = len(rows)
    masks = PackedMasks.of(np.ones((count, 1, 1), bool))
    point = np.array([(x, 1.0, z) for _, x, z in rows]).reshape(-1, 3)
    feature = np.tile(np.float32([1, 0]), (count, 1))
    return Detected(np.array([v for v, *_ in rows], int), point, feature, np.ones(count, int), np.ones(count), masks, "")


def content(clusters) -> list:
    return [(c.position.tolist(), c.track.tolist(), c.members.tolist()) for c in clusters]


@given(tours, tours)
def test_detections_are_numbered_through_both_tours_and_each_is_in_one_cluster(first, second):
    points = np.concatenate([first.point, second.point])[:, [0, 2]]
    found = build_map([first, second], RADIUS_M)
    assert sorted(k for c in found for k in c.members.tolist()) == list(range(len(first) + len(second)))
    for c in found:
        assert np.array_equal(points[c.members], c.track)
        assert (np.diff(c.members) > 0).all() and (np.diff(c.views) >= 0).all()
        later = c.members >= len(first)
        assert not len(first) or (c.views[later] > first.view.max()).all()


@given(tours)
def test_a_tour_that_shows_nothing_adds_nothing_and_the_same_tour_again_stays_within_its_clusters(seen):
    nothing = tour([])
    alone = content(build_map([seen], RADIUS_M))
    assert content(build_map([seen, nothing], RADIUS_M)) == content(build_map([nothing, seen], RADIUS_M)) == alone


def test_what_stays_joins_its_cluster_and_what_moves_begins_one():
    before, after = tour([(0, 0.0, 0.0), (1, 2.0, 0.0)]), tour([(0, 0.1, 0.0), (1, 2.0, 2.0)])
    found = build_map([before, after], RADIUS_M)
    assert [c.members.tolist() for c in found] == [[0, 2], [1], [3]]
