"""Greedy suppression gives what torchvision's gives."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from ovman.perception.non_max_suppression import non_max_suppression


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("spread", [5, 40, 1000])
def test_the_same_boxes_stay_in_the_same_order(seed, spread):
    from torchvision.ops import nms  # takes a second, in each process that collects the tests

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


def test_boxes_that_overlap_by_no_more_than_the_bound_stay():
    """By two thirds of what they cover together."""
    boxes = np.float32([[0, 0, 10, 10], [0, 2, 10, 12]])
    for iou_threshold, stay in ((0.66, [1]), (0.67, [1, 0])):
        assert non_max_suppression(boxes, np.float32([0.5, 0.9]), iou_threshold, 2).tolist() == stay


def test_of_no_boxes_none_stays():
    assert non_max_suppression(np.zeros((0, 4), np.float32), np.zeros(0, np.float32), 0.7, 100).tolist() == []
