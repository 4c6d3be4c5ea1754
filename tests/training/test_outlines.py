import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ovman.training.outlines import MIN_MASK_PX, labels, outline

SIDE = 60


def filled(polygon):
    canvas = np.zeros((SIDE, SIDE), np.uint8)
    cv2.fillPoly(canvas, [np.round(polygon).astype(np.int32)], 1)
    return canvas.astype(bool)


boxes = st.lists(st.tuples(*[st.integers(2, 40)] * 2, *[st.integers(8, 16)] * 2), min_size=1, max_size=3)


@given(boxes)
def test_an_outline_covers_its_mask_whatever_its_pieces(parts):
    mask = np.zeros((SIDE, SIDE), bool)
    for x, y, width, height in parts:
        mask[y : y + height, x : x + width] = True
    drawn = filled(outline(mask))
    assert not (mask & ~drawn).any()
    # What is too much is the seams, a pixel or two wide.
    assert (drawn & ~mask).sum() <= 3 * SIDE * (len(parts) - 1)


def test_a_speck_has_no_outline():
    mask = np.zeros((SIDE, SIDE), bool)
    mask[5:8, 5:8] = True
    assert outline(mask) is None


def test_labels_are_one_line_for_each_large_instance_in_fractions_of_the_picture():
    ids = np.full((SIDE, SIDE), -1)
    ids[5:25, 5:25], ids[30:34, 30:34], ids[40:55, 10:50] = 0, 1, 2
    lines = labels(ids)
    assert MIN_MASK_PX > 4 * 4 and len(lines) == 2
    for line in lines:
        cls, *points = line.split()
        assert cls == "0" and len(points) % 2 == 0 and all(0 <= float(p) <= 1 for p in points)
