"""Instance masks as polygons for the detector's trainer."""

from __future__ import annotations

import cv2
import numpy as np

MIN_MASK_PX = 80
"""Smallest instance in the detector's training data."""
SPECK_PX = 20
"""Smaller pieces of an instance are dropped from its outline."""


def outline(mask: np.ndarray) -> np.ndarray | None:
    """One closed polygon (N, 2) in pixels around all pieces of a mask (H, W) bool, joined by seams; None for a speck."""
    pieces = [
        c[:, 0].astype(float)
        for c in cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        if len(c) >= 3 and cv2.contourArea(c) >= SPECK_PX
    ]
    if not pieces:
        return None
    pieces.sort(key=len, reverse=True)
    whole = pieces[0]
    for piece in pieces[1:]:
        gaps = ((whole[:, None] - piece[None]) ** 2).sum(axis=2)
        i, j = np.unravel_index(gaps.argmin(), gaps.shape)
        turned = np.concatenate([piece[j:], piece[: j + 1]])
        whole = np.concatenate([whole[: i + 1], turned, whole[i:]])
    return _simple(whole)


def _simple(polygon: np.ndarray) -> np.ndarray:
    """The polygon without the points in the middle of straight stretches."""
    step = np.diff(np.concatenate([polygon[-1:], polygon, polygon[:1]]), axis=0)
    turns = (step[:-1] != step[1:]).any(axis=1)
    return polygon[turns] if turns.sum() >= 3 else polygon


def labels(ids: np.ndarray, min_mask_px: int = MIN_MASK_PX) -> list[str]:
    """Lines of a label file for ids (H, W): class 0, then the outline in fractions of the picture's width and height."""
    height, width = ids.shape
    lines = []
    for number in range(int(ids.max()) + 1):
        mask = ids == number
        if mask.sum() < min_mask_px:
            continue
        polygon = outline(mask)
        if polygon is not None:
            points = (polygon + 0.5) / [width, height]
            lines.append("0 " + " ".join(f"{v:.4f}" for v in points.ravel()))
    return lines
