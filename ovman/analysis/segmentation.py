"""Detected masks against the true instances of a tour."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.perception.overlap import LEAST_IOU, intersection_over_union

TRUE, DETECTED = "true", "detected"
"""Where a mask comes from."""


@dataclass(frozen=True, slots=True, eq=False)
class Segmented:
    """What became of T true instances in single views, and of N detected masks; indices are into a scene's objects.

    true_object, true_px, recalled: (T,) of every instance that is large enough. px (N,): size of each mask; object (N,): what it
    shows, -1 for a mask that overlaps with no instance enough; object_px (N,): that instance's size; doubled (N,): whether a
    mask of higher confidence in the same view shows the same instance.
    """

    true_object: np.ndarray
    true_px: np.ndarray
    recalled: np.ndarray
    px: np.ndarray
    object: np.ndarray
    object_px: np.ndarray
    doubled: np.ndarray


def segmented(masks: np.ndarray, confidence: np.ndarray, ids: np.ndarray, count: int, min_mask_px: int) -> Segmented:
    """One view: masks (N, H, W) bool and their confidence (N,) against ids (H, W) of `count` objects, -1 for none of them.

    A true instance counts from `min_mask_px` pixels on; a mask on a smaller one is right too, as in `overlap.found`.
    """
    iou, sizes = intersection_over_union(masks, ids, count)
    true = np.flatnonzero(sizes >= min_mask_px)
    recalled = iou[:, true].max(axis=0, initial=0.0) >= LEAST_IOU
    shown = np.full(len(masks), -1)
    if count and len(masks):
        best = iou.argmax(axis=1)
        right = iou[np.arange(len(masks)), best] >= LEAST_IOU
        shown[right] = best[right]
    doubled = np.zeros(len(masks), bool)
    met: set[int] = set()
    for n in np.argsort(-np.asarray(confidence), kind="stable"):
        if shown[n] >= 0:
            doubled[n] = int(shown[n]) in met
            met.add(int(shown[n]))
    object_px = np.where(shown >= 0, sizes[shown], 0) if count else np.zeros(len(masks), int)
    return Segmented(true, sizes[true], recalled, masks.sum(axis=(1, 2)), shown, object_px, doubled)


def joined(parts: Iterable[Segmented]) -> Segmented:
    """Several views of one scene as one."""
    every: Sequence[Segmented] = list(parts)
    return Segmented(*(np.concatenate([getattr(part, name) for part in every]) for name in Segmented.__dataclass_fields__))
