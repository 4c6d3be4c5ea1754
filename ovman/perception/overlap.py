"""Masks against true instances: intersection over union, recall and precision."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LEAST_IOU = 0.5
"""Least IoU of a mask with the instance that it shows."""


@dataclass(frozen=True, slots=True)
class Found:
    """Counts over pictures: true instances, recalled ones among them, detections, and right ones among them."""

    true: int = 0
    recalled: int = 0
    found: int = 0
    right: int = 0

    def __add__(self, other: Found) -> Found:
        return Found(self.true + other.true, self.recalled + other.recalled, self.found + other.found, self.right + other.right)

    @property
    def recall(self) -> float:
        """recalled / true; NaN without true instances."""
        return self.recalled / self.true if self.true else float("nan")

    @property
    def precision(self) -> float:
        """right / found; NaN without detections."""
        return self.right / self.found if self.found else float("nan")


def intersection_over_union(masks: np.ndarray, ids: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """IoU (N, count) of masks (N, H, W) bool with the instances 0 ... count - 1 of ids (H, W), where -1 is no instance, and the
    instances' sizes (count,) in pixels."""
    sizes = np.bincount(ids[ids >= 0].ravel(), minlength=count)[:count]
    if not len(masks):
        return np.zeros((0, count)), sizes
    inter = np.stack([np.bincount(ids[mask & (ids >= 0)], minlength=count)[:count] for mask in masks])
    return inter / np.maximum(masks.sum(axis=(1, 2))[:, None] + sizes[None] - inter, 1), sizes


def found(iou: np.ndarray, sizes: np.ndarray, min_mask_px: int, least_iou: float = LEAST_IOU) -> Found:
    """Counts for IoU (N, K): a true instance has at least `min_mask_px` pixels; a detection of a smaller one is right, too."""
    true = sizes >= min_mask_px
    recalled = iou.max(axis=0, initial=0.0) >= least_iou
    right = iou.max(axis=1, initial=0.0) >= least_iou
    return Found(int(true.sum()), int((true & recalled).sum()), len(iou), int(right.sum()))
