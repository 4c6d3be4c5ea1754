"""From views to detections."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ovman.perception.backprojection import Camera, median_point
from ovman.perception.detections import detect_views
from ovman.perception.tour_files import View

SIDE_PX = 16


class Eyes:
    """Finds in the n-th picture the masks that it was told."""

    def __init__(self, masks):
        self.masks = masks

    def detect(self, pictures):
        assert len(pictures) == len(self.masks)
        return [SimpleNamespace(masks=m, confidence=np.linspace(0.9, 0.3, len(m))) for m in self.masks]


class Colours:
    """Embeds a crop as its mean colour."""

    side_px = 4
    contrast = 1.0

    def images(self, crops):
        assert crops.dtype == np.uint8 and crops.shape[1:] == (4, 4, 3)
        mean = crops.mean(axis=(1, 2))
        return (mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-9)).astype(np.float32)


def square(top, left, side):
    mask = np.zeros((SIDE_PX, SIDE_PX), bool)
    mask[top : top + side, left : left + side] = True
    return mask


def view(yaw_deg=0.0, depth=2.0):
    return View(
        np.full((SIDE_PX, SIDE_PX, 3), 40, np.uint8),
        np.full((SIDE_PX, SIDE_PX), depth, np.float32),
        Camera((0.0, 1.5, 0.0), yaw_deg, 0.0, 90.0),
    )


def test_small_masks_are_left_out_and_the_others_keep_their_order():
    masks = [
        np.stack([square(0, 0, 3), square(4, 4, 8), square(8, 8, 4)]),
        np.zeros((0, SIDE_PX, SIDE_PX), bool),
        square(2, 2, 5)[None],
    ]
    found = detect_views([view(), view(90.0), view(180.0)], Eyes(masks), Colours(), 10, 0.1, "digest")
    assert found.view.tolist() == [0, 0, 2] and found.pixels.tolist() == [64, 16, 25] and found.content == "digest"
    assert found.confidence == pytest.approx([0.6, 0.3, 0.9])
    assert np.array_equal(found.masks(), np.stack([masks[0][1], masks[0][2], masks[2][0]]))
    assert np.linalg.norm(found.feature, axis=1) == pytest.approx(np.ones(3)), "one embedding each"
    assert found.point[0] == pytest.approx([0.0, 1.5, 2.0]) and found.point[2][2] == pytest.approx(-2.0)


def test_pixels_without_depth_have_no_place():
    here = view()
    here.depth[:, 8:] = 0.0
    masks = np.stack([square(4, 6, 4), square(4, 9, 5)])
    found = detect_views([here], Eyes([masks]), Colours(), 10, 0.1)
    assert len(found) == 1 and found.pixels.tolist() == [16], "the mask itself stays whole"
    only = masks[0] & (here.depth > 0)
    assert found.point[0] == pytest.approx(median_point(here.depth, only, here.camera))


def test_a_tour_that_shows_nothing_is_empty():
    found = detect_views([view()] * 2, Eyes([np.zeros((0, SIDE_PX, SIDE_PX), bool)] * 2), Colours(), 10, 0.1)
    assert len(found) == 0 and found.point.shape == (0, 3) and found.feature.shape == (0, 3)
    assert found.masks().shape == (0, SIDE_PX, SIDE_PX)
