from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.report.show.frame import PlanFrame

coordinates = st.floats(-30, 30)
points = st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=20)


@given(points, st.floats(50, 2000), st.floats(50, 2000), st.floats(0.1, 3.0))
def test_what_is_drawn_is_where_it_is(points, width, highest, margin):
    frame = PlanFrame.around(points, width, highest, margin)
    for x, z in points:
        assert frame.world(*frame.at(x, z)) == pytest.approx((x, z), abs=1e-6)
        assert frame.shows(x, z)


@given(points, st.floats(50, 2000), st.floats(50, 2000), st.floats(0.1, 3.0))
def test_a_frame_keeps_its_margin_and_its_size(points, width, highest, margin):
    frame = PlanFrame.around(points, width, highest, margin)
    assert frame.width == width
    assert frame.height <= highest * (1 + 1e-9)
    for x, z in points:
        u, v = frame.at(x, z)
        assert min(u, v, frame.width - u, frame.height - v) >= margin * frame.scale * (1 - 1e-6)


def test_x_goes_right_z_goes_up_and_a_metre_is_a_metre():
    frame = PlanFrame.around([(0, 0), (4, 3)], 600, 600, 0.5)
    origin, east, north = frame.at(0, 0), frame.at(1, 0), frame.at(0, 1)
    assert (east[0] - origin[0], east[1] - origin[1]) == pytest.approx((frame.scale, 0))
    assert (north[0] - origin[0], north[1] - origin[1]) == pytest.approx((0, -frame.scale))


def test_no_points_no_frame():
    with pytest.raises(ValueError, match="needs a point"):
        PlanFrame.around([], 100, 100, 1)
