"""Parts of drawings: the frame of a plan, outlines of masks."""

from __future__ import annotations

import re

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.records.visit import TourError, write_tour
from ovman.report.show.plan import Frame
from ovman.report.show.tours import embed_picture, trace_outline


def test_x_goes_right_and_z_up_and_a_metre_is_a_metre():
    frame = Frame.around([(0, 0), (4, 3)])
    origin, east, north = frame.at((0, 0)), frame.at((1, 0)), frame.at((0, 1))
    assert (east[0] - origin[0], east[1] - origin[1]) == pytest.approx((frame.scale, 0), abs=0.11)
    assert (north[0] - origin[0], north[1] - origin[1]) == pytest.approx((0, -frame.scale), abs=0.11)


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
    file = tmp_path / "tour.zip"
    write_tour(file, {})
    with pytest.raises(TourError, match="00_rgb.png"):
        embed_picture(file, 0)
