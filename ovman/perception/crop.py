"""Square crops of instances for the image encoder."""

from __future__ import annotations

import cv2
import numpy as np

GREY = 127
"""Value of the padding of a crop."""


def crop(rgb: np.ndarray, mask: np.ndarray, pad: float, side_px: int) -> np.ndarray:
    """Square crop (side_px, side_px, 3) uint8 of rgb (H, W, 3) around mask (H, W) bool.

    The mask's box is grown by the fraction `pad` of its longer side on every side and cut at the picture's edges; padding
    with grey makes it square without stretching. ValueError for an empty mask.
    """
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        raise ValueError("an empty mask has no crop")
    grown = round(pad * max(rows[-1] - rows[0], columns[-1] - columns[0]) + 1)
    top, left = max(rows[0] - grown, 0), max(columns[0] - grown, 0)
    return squared(rgb[top : rows[-1] + grown + 1, left : columns[-1] + grown + 1], side_px)


def squared(part: np.ndarray, side_px: int) -> np.ndarray:
    """A part (H, W, 3) uint8 of a picture, scaled to fit into (side_px, side_px, 3) and padded with grey."""
    scale = side_px / max(part.shape[:2])
    height, width = (max(round(n * scale), 1) for n in part.shape[:2])
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    square = np.full((side_px, side_px, 3), GREY, np.uint8)
    y, x = (side_px - height) // 2, (side_px - width) // 2
    square[y : y + height, x : x + width] = cv2.resize(part, (width, height), interpolation=method)
    return square
