"""Greedy class-agnostic non-maximum suppression."""

from __future__ import annotations

import numpy as np


def non_max_suppression(boxes: np.ndarray, confidence: np.ndarray, iou_threshold: float, at_most: int) -> np.ndarray:
    """Indices of at most `at_most` kept boxes by descending confidence.

    A box is kept if its IoU with every kept box of higher confidence is at most `iou_threshold`. boxes: (N, 4) float32, corners
    x, y, x, y with the smaller coordinates first; confidence: (N,), ties in the order of the boxes. The result equals
    torchvision's `nms`, whose import takes two seconds. ultralytics' own choice between two implementations depends on what the
    process has imported.
    """
    order = np.argsort(-confidence, kind="stable")
    left, top, right, bottom = boxes[order].T
    area = (right - left) * (bottom - top)
    stay: list[int] = []
    waiting = np.arange(len(order))
    while len(waiting) and len(stay) < at_most:
        first, waiting = waiting[0], waiting[1:]
        stay.append(first)
        width = np.minimum(right[first], right[waiting]) - np.maximum(left[first], left[waiting])
        height = np.minimum(bottom[first], bottom[waiting]) - np.maximum(top[first], top[waiting])
        shared = np.maximum(width, 0) * np.maximum(height, 0)
        with np.errstate(invalid="ignore"):
            overlap = shared / (area[first] + area[waiting] - shared)
        waiting = waiting[~(overlap > np.float64(iou_threshold))]
    kept: np.ndarray = order[np.array(stay, int)]
    return kept
