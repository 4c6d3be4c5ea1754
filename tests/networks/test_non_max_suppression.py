"""Greedy suppression gives what torchvision's gives."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torchvision.ops import nms

from ovman.perception.non_max_suppression import non_max_suppression

pytestmark = pytest.mark.networks


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("spread", [5, 40, 1000])
def test_the_same_boxes_stay_in_the_same_order(seed, spread):
    draw = np.random.default_rng(seed)
    corner = draw.uniform(0, spread, (120, 2))
    boxes = np.concatenate([corner, corner + draw.uniform(0, 30, (120, 2))], 1).astype(np.float32)
    boxes[::7] = boxes[0]  # the same box several times
    boxes[5::9, 2:] = boxes[5::9, :2]  # and boxes without an area
    sure = draw.integers(0, 40, 120).astype(np.float32) / 40  # some as sure as others
    for iou_threshold in (0.0, 0.3, 0.7, 1.0):
        expected = nms(torch.from_numpy(boxes), torch.from_numpy(sure), iou_threshold).numpy()
        assert np.array_equal(non_max_suppression(boxes, sure, iou_threshold, 120), expected)
        assert np.array_equal(non_max_suppression(boxes, sure, iou_threshold, 4), expected[:4])
