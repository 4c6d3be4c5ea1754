"""Detections in recorded pictures, with their IoU with the true instances."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ovman.perception.overlap import intersection_over_union
from ovman.perception.protocols import Segmenter
from ovman.training.picture_files import RecordedPicture, read
from ovman.training.pictures import Picture

TOGETHER = 16
"""Batch size of the detector."""


def seen(
    detector: Segmenter, chosen: Sequence[RecordedPicture], min_mask_px: int
) -> Iterator[tuple[Picture, np.ndarray, np.ndarray, np.ndarray]]:
    """For each picture: the picture, the detected masks (N, H, W) of at least `min_mask_px`, their IoU (N, K) with its objects,
    and these objects' sizes (K,) in pixels.
    """
    for start in range(0, len(chosen), TOGETHER):
        pictures = list(read(chosen[start : start + TOGETHER]))
        for picture, found in zip(pictures, detector.detect([p.rgb for p in pictures]), strict=True):
            masks = found.masks[found.masks.sum(axis=(1, 2)) >= min_mask_px]
            yield picture, masks, *intersection_over_union(masks, picture.ids, len(picture.objects))
