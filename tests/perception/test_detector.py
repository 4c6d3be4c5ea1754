"""Greedy suppression keeps the surest of boxes that overlap."""

from __future__ import annotations

import numpy as np

from ovman.perception.detector import non_max_suppression


def test_boxes_that_overlap_by_no_more_than_the_bound_stay():
    """By two thirds of what they cover together."""
    boxes = np.float32([[0, 0, 10, 10], [0, 2, 10, 12]])
    for iou_threshold, stay in ((0.66, [1]), (0.67, [1, 0])):
        assert non_max_suppression(boxes, np.float32([0.5, 0.9]), iou_threshold, 2).tolist() == stay


def test_of_no_boxes_none_stays():
    assert non_max_suppression(np.zeros((0, 4), np.float32), np.zeros(0, np.float32), 0.7, 100).tolist() == []
