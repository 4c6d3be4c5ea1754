"""Detect the instances in the views of a tour: masks, their positions in the world, and embeddings of their crops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.perception.backprojection import Camera, median_points
from ovman.perception.detector import Detector
from ovman.perception.encoder import Encoder, crop
from ovman.perception.records import Detected, keep_masks


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """One frame. rgb: (H, W, 3) uint8; depth: (H, W) metres along the optical axis, 0 if unknown; camera: of both."""

    rgb: np.ndarray
    depth: np.ndarray
    camera: Camera


def detections(
    views: Sequence[View], detector: Detector, encoder: Encoder, min_mask_px: int, crop_padding: float, content: str = ""
) -> Detected:
    """Return the detections in the views of a tour (at least one), in their order.

    A mask counts if it has at least `min_mask_px` pixels and some of them have depth; its position is the median of those
    (Eq. backproj). Raises ValueError for a tour without views.
    """
    if not views:
        raise ValueError("a tour without views shows nothing")
    masks, points, crops, confidence, numbers = [], [], [], [], []
    for number, (view, seen) in enumerate(zip(views, detector.detect([view.rgb for view in views]), strict=True)):
        large = seen.masks.sum(axis=(1, 2), dtype=np.int64) >= min_mask_px
        found, sure = seen.masks[large], seen.confidence[large]
        places = median_points(view.depth, found, view.camera)
        placed = ~np.isnan(places[:, 0])
        found, sure = found[placed], sure[placed]
        masks.append(found)
        points.append(places[placed])
        confidence.append(sure)
        numbers.append(np.full(len(found), number, np.int64))
        crops += [crop(view.rgb, mask, crop_padding, encoder.side_px) for mask in found]
    every = np.concatenate(masks)
    squares = np.stack(crops) if crops else np.zeros((0, encoder.side_px, encoder.side_px, 3), np.uint8)
    return Detected(
        view=np.concatenate(numbers),
        point=np.concatenate(points),
        feature=encoder.images(squares),
        pixels=every.sum(axis=(1, 2), dtype=np.int64),
        confidence=np.concatenate(confidence).astype(np.float32),
        masks=keep_masks(every),
        content=content,
    )
