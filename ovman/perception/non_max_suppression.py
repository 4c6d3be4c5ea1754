"""Of boxes that overlap, the surest: greedy suppression, whatever their classes are."""

from __future__ import annotations

import numpy as np


def non_max_suppression(boxes: np.ndarray, confidence: np.ndarray, iou_threshold: float, at_most: int) -> np.ndarray:
    """Indices of the first `at_most` boxes that stay, the surest first: those that no surer one that stays overlaps by more than
    `iou_threshold`.

    boxes: (N, 4) float32, two opposite corners x, y, x, y with the smaller coordinates first; confidence: (N,). Of equally sure
    boxes the first comes first. Gives what torchvision's `nms` gives, without the two seconds that its import takes; ultralytics
    takes that one or a slow one of its own, by what the process happens to have imported.
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
    return order[np.array(stay, int)]
