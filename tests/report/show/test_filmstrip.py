from __future__ import annotations

import re

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.records.visit import TourError
from ovman.report.show.filmstrip import outline, picture


@given(st.integers(0, 60), st.integers(0, 40), st.integers(3, 60), st.integers(3, 40))
def test_an_outline_fills_to_its_mask(left, top, width, height):
    mask = np.zeros((120, 140), np.uint8)
    cv2.ellipse(mask, (left + 35, top + 35), (width // 2 + 2, height // 2 + 2), 0, 0, 360, 1, -1)
    points = np.array(re.findall(r"(\d+) (\d+)", outline(mask > 0)), np.int32)
    filled = cv2.fillPoly(np.zeros_like(mask), [points], 1)
    union = np.count_nonzero(filled | mask)
    assert np.count_nonzero(filled & mask) / union > 0.75


def test_an_outline_has_every_part_of_a_mask():
    mask = np.zeros((40, 40), bool)
    mask[2:10, 2:10] = mask[20:30, 20:30] = True
    assert outline(mask).count("M") == 2
    assert outline(np.zeros((40, 40), bool)) == ""


def test_a_picture_that_is_not_there_is_named(tmp_path):
    with pytest.raises(TourError, match="00_rgb.png"):
        picture(tmp_path / "00_rgb.png")
