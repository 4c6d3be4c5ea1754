"""Overlap of masks with true instances."""

from __future__ import annotations

import numpy as np

LEAST_IOU = 0.5
"""Least IoU of a mask with the instance that it shows."""


def intersection_over_union(masks: np.ndarray, ids: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the IoU (N, count) of masks (N, H, W) bool with the instances of ids (H, W), and the instances' sizes (count,).

    ids: 0 ... count - 1, -1 where there is no instance; sizes are in pixels.
    """
    sizes = np.bincount(ids[ids >= 0].ravel(), minlength=count)[:count]
    if not len(masks):
        return np.zeros((0, count)), sizes
    inter = np.stack([np.bincount(ids[mask & (ids >= 0)], minlength=count)[:count] for mask in masks])
    return inter / np.maximum(masks.sum(axis=(1, 2))[:, None] + sizes[None] - inter, 1), sizes
