"""Parts of drawings: the frame of a plan, labels that keep off each other, outlines of masks."""

from __future__ import annotations

import re

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.records.visit import TourError
from ovman.report.show.svg import Box, Labels, PlanFrame
from ovman.report.show.tours import embed_picture, trace_outline

coordinates = st.floats(-30, 30)
points = st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=20)
places = st.tuples(st.floats(60, 540), st.floats(60, 540))


@given(points, st.floats(50, 2000), st.floats(50, 2000), st.floats(0.1, 3.0))
def test_a_frame_shows_its_points_with_a_margin(points, width, highest, margin):
    frame = PlanFrame.around(points, width, highest, margin)
    assert frame.width == width and frame.height <= highest * (1 + 1e-9)
    for x, z in points:
        u, v = frame.at(x, z)
        assert frame.shows(x, z)
        assert min(u, v, frame.width - u, frame.height - v) >= margin * frame.scale * (1 - 1e-6)


def test_x_goes_right_and_z_up_and_a_metre_is_a_metre():
    frame = PlanFrame.around([(0, 0), (4, 3)], 600, 600, 0.5)
    origin, east, north = frame.at(0, 0), frame.at(1, 0), frame.at(0, 1)
    assert (east[0] - origin[0], east[1] - origin[1]) == pytest.approx((frame.scale, 0))
    assert (north[0] - origin[0], north[1] - origin[1]) == pytest.approx((0, -frame.scale))
    with pytest.raises(ValueError, match="needs a point"):
        PlanFrame.around([], 100, 100, 1)


@given(places, st.floats(3, 12))
def test_a_label_is_next_to_what_it_names_and_in_the_drawing(at, radius):
    box = Labels(600, 600).place(at, radius, "12–34", 12)
    assert box.overlap(Box.around(at, radius / 2**0.5, radius / 2**0.5)) == 0
    assert box.left >= 0 and box.top >= 0 and box.right <= 600 and box.bottom <= 600


def test_labels_keep_off_each_other_and_off_what_is_kept():
    labels = Labels(600, 600)
    boxes = [labels.place((300, 300), 6, "7", 12) for _ in range(8)]
    assert all(a.overlap(b) == 0 for i, a in enumerate(boxes) for b in boxes[:i])
    labels = Labels(600, 600)
    labels.keep((315, 300), 8)
    assert labels.place((300, 300), 6, "7", 12).overlap(Box.around((315, 300), 8, 8)) == 0


@given(st.integers(0, 60), st.integers(0, 40), st.integers(3, 60), st.integers(3, 40))
def test_an_outline_fills_to_its_mask(left, top, width, height):
    mask = np.zeros((120, 140), np.uint8)
    cv2.ellipse(mask, (left + 35, top + 35), (width // 2 + 2, height // 2 + 2), 0, 0, 360, 1, -1)
    points = np.array(re.findall(r"(\d+) (\d+)", trace_outline(mask > 0)), np.int32)
    filled = cv2.fillPoly(np.zeros_like(mask), [points], 1)
    assert np.count_nonzero(filled & mask) / np.count_nonzero(filled | mask) > 0.75


def test_an_outline_has_every_part_of_a_mask():
    mask = np.zeros((40, 40), bool)
    mask[2:10, 2:10] = mask[20:30, 20:30] = True
    assert trace_outline(mask).count("M") == 2 and trace_outline(np.zeros((40, 40), bool)) == ""


def test_a_missing_picture_is_named(tmp_path):
    with pytest.raises(TourError, match="00_rgb.png"):
        embed_picture(tmp_path / "00_rgb.png")
