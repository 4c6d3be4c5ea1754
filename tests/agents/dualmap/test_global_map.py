"""DualMap's global map: furniture at its place is one anchor, at another place another, and what stands on it is kept with it."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.agents.dualmap.cloud import Cloud
from ovman.agents.dualmap.global_map import Anchor, GlobalMap, overlap
from ovman.agents.dualmap.local_map import Departure, LocalMap
from ovman.agents.dualmap.map_object import MapObject, RunObservation
from ovman.agents.dualmap.relation import lies_on, major_plane
from tests.agents.dualmap.boxworld import CONSTANTS, DENSE, FEATURES, TEN, Box, feature, surface, walk

LOCAL, ANCHORS = CONSTANTS.local_map, CONSTANTS.global_map
HALF_METRE = Box((2.0, 0.25, 1.0), (0.5, 0.5, 0.5), class_id=3)


def thing(box: Box, uid: int = 0, points: int = 4000) -> MapObject:
    eye = np.array([box.centre[0] + 2, 3.0, box.centre[2] + 2])
    cloud = Cloud.of(surface(box, eye, points, np.random.default_rng(uid)))
    one = RunObservation(box.class_id, 0.9, feature(box.class_id), cloud, box.low_mobility)
    return MapObject.of(uid, [one] * 9, range(9), LOCAL)


def anchors(*boxes: Box, preloaded: tuple[Anchor, ...] = ()) -> list[Anchor]:
    found = GlobalMap(LOCAL.voxel_m, ANCHORS, preloaded)
    found.take(Departure(thing(box, uid), ()) for uid, box in enumerate(boxes, start=len(preloaded)))
    return found.anchors


@pytest.mark.parametrize(("shift_m", "count"), [(0.02, 1), (0.25, 2), (4.0, 2)])
def test_half_a_metre_of_furniture_shifted_a_little_is_the_same_and_shifted_far_another(shift_m: float, count: int):
    found = anchors(HALF_METRE, HALF_METRE.moved(shift_m, 0))
    assert len(found) == count
    assert found[0].uid == 0
    assert found[0].position == pytest.approx([2.0, 1.0], abs=0.02)


def test_a_preloaded_anchor_keeps_its_name_and_place_though_its_furniture_has_moved():
    before = tuple(anchors(HALF_METRE))
    after = anchors(HALF_METRE.moved(3.0, 1.0), HALF_METRE.moved(3.01, 1.0), preloaded=before)
    assert [anchor.uid for anchor in after] == [0, 1]
    assert after[0] is before[0]
    assert after[1].position == pytest.approx([5.0, 2.0], abs=0.03)


def test_the_looks_of_a_merged_anchor_are_those_of_more_points_and_its_related_those_of_both():
    small, large = Box((0, 0.25, 0), (0.5, 0.5, 0.5), 1), Box((0, 0.25, 0), (1.0, 0.5, 1.0), 2)
    cup = thing(Box((0, 0.55, 0), (0.1, 0.1, 0.1), 5, low_mobility=False), uid=9)

    def merged(first: Box, second: Box) -> Anchor:
        found = GlobalMap(LOCAL.voxel_m, ANCHORS)
        found.take([Departure(thing(first, 0), (cup,)), Departure(thing(second, 1), (cup,))])
        (anchor,) = found.anchors
        return anchor

    for one in (merged(small, large), merged(large, small)):
        assert one.class_id == 2 and one.feature == pytest.approx(feature(2))
        assert one.uid == 0 and len(one.related) == 2 and one.observations == 18
        assert one.footprint == pytest.approx([-0.5, -0.5, 0.5, 0.5], abs=0.03)


def test_overlap_is_over_the_smaller_area():
    rectangles = np.array([[0, 0, 1, 1], [0, 0, 2, 2], [0.5, 0, 1.5, 1], [1, 0, 2, 1], [0, 0, 0, 1]], float)
    assert overlap(rectangles[0], rectangles) == pytest.approx([1, 1, 0.5, 0, 0])


TABLE = Box((0, 0.35, 0), (1.2, 0.7, 0.8), class_id=0)


@pytest.mark.parametrize(
    ("upper", "on"),
    [
        (Box((0.2, 0.75, 0.1), (0.1, 0.1, 0.1), 1, False), True),
        (Box((0.6, 0.75, 0.0), (0.2, 0.1, 0.2), 1, False), False),  # half beside it
        (Box((0.56, 0.75, 0.0), (0.1, 0.1, 0.1), 1, False), True),  # four fifths over it
        (Box((0.2, 1.25, 0.1), (0.1, 0.1, 0.1), 1, False), False),  # half a metre above it
        (Box((0.2, 0.05, 0.1), (0.1, 0.1, 0.1), 1, False), False),  # below it
        (Box((0.2, 0.75, 0.1), (0.1, 0.1, 0.1), 1, True), False),  # furniture lies on nothing
    ],
)
def test_what_is_no_furniture_lies_on_furniture_if_it_is_over_its_plane(upper: Box, on: bool):
    assert lies_on(thing(upper, 1), thing(TABLE), ANCHORS) is on
    assert not lies_on(thing(TABLE), thing(upper, 1), ANCHORS)


def test_the_major_plane_of_a_table_seen_from_above_is_its_top():
    assert major_plane(thing(TABLE), ANCHORS.plane_bin_m) == pytest.approx(0.7, abs=ANCHORS.plane_bin_m)
    assert major_plane(thing(Box((0, 1, 0), (0.1, 0.1, 0.1), 1, False)), ANCHORS.plane_bin_m) is None


def test_furniture_that_has_settled_leaves_the_local_map_with_what_is_on_it_and_the_rest_is_dropped():
    table = Box((2.0, 0.35, 1.9), (0.6, 0.7, 0.6), class_id=12)
    cup = Box((2.05, 0.77, 1.95), (0.14, 0.14, 0.14), class_id=13, low_mobility=False)
    ball = Box((4.0, 0.1, 2.0), (0.2, 0.2, 0.2), class_id=14, low_mobility=False)
    local = LocalMap(FEATURES, LOCAL, np.random.default_rng(0), handing_on=ANCHORS, unknown=4)
    for observations in walk([*TEN, table, cup, ball], DENSE):
        local.observe([RunObservation.of(one, 0) for one in observations])
    local.flush()
    left = {departure.object.class_id: [up.class_id for up in departure.related] for departure in local.departures}
    assert set(left) == {0, 1, 2, 3, 5, 6, 7, 8, 9, 12}, "all furniture but what is unknown"
    assert left.pop(12) == [13] and not any(left.values())
    assert local.objects == []


def test_a_walk_that_shows_furniture_twice_hands_it_on_twice_and_it_is_one_anchor():
    views = [*DENSE, *[(3.0, 9.0, 0.0)] * 40, *DENSE]
    local = LocalMap(FEATURES, LOCAL, np.random.default_rng(0), handing_on=ANCHORS)
    for observations in walk(TEN, views):
        local.observe([RunObservation.of(one, 0) for one in observations])
    local.flush()
    found = GlobalMap(LOCAL.voxel_m, ANCHORS)
    found.take(local.departures)
    assert len(local.departures) == 20
    assert sorted(anchor.class_id for anchor in found.anchors) == list(range(10))
