"""Masks from prototypes: a mask is where a weighted sum of the prototypes, scaled to the picture, is positive within its box."""

from __future__ import annotations

import math

import numpy as np

from ovman.perception.letterbox import Letterbox

FINER = 4
"""Pixels of a frame on a side of a prototype's pixel."""


def masks(coefficients: np.ndarray, prototypes: np.ndarray, boxes: np.ndarray, letterbox: Letterbox) -> np.ndarray:
    """Masks (N, height, width) bool of a picture.

    coefficients: (N, C) float32; prototypes: (C, H, W) float32 of the frame; boxes: (N, 4) of the picture, as corners x, y, x, y.
    The scaling is bilinear, in float32, and in the order of torch's `interpolate`, whose signs it gives.
    """
    count, height, width = prototypes.shape
    sums = (coefficients @ prototypes.reshape(count, -1)).reshape(-1, height, width)
    around = [FINER * size - scaled for size, scaled in zip((height, width), letterbox.scaled, strict=True)]
    padding = around[0] | around[1]
    factor = FINER // math.gcd(FINER, padding | padding // 2)  # at which the grey around the picture ends between two pixels
    if factor > 1:
        sums = _scaled(sums, (height * factor, width * factor))
    sums = _without_grey(sums, letterbox)
    found = np.zeros((len(boxes), *letterbox.shape), bool)
    for mask, logits, (left, top, right, bottom) in zip(found, sums, np.ceil(boxes).astype(int), strict=True):
        # A pixel counts from the box's first side on and before its last one.
        mask[top:bottom, left:right] = _scaled(logits[None], letterbox.shape, (top, bottom), (left, right))[0] > 0
    return found


def _without_grey(sums: np.ndarray, letterbox: Letterbox) -> np.ndarray:
    sizes, shape = sums.shape[1:], letterbox.shape
    gain = min(size / side for size, side in zip(sizes, shape, strict=True))
    content = [max(round(side * gain), 1) for side in shape]
    top, left = (round((size - inner) / 2 - 0.1) for size, inner in zip(sizes, content, strict=True))
    return sums[:, top : top + content[0], left : left + content[1]]


def _scaled(
    sums: np.ndarray, shape: tuple[int, int], rows: tuple[int, int] | None = None, columns: tuple[int, int] | None = None
) -> np.ndarray:
    """The part `rows` by `columns` (all without) of sums (N, h, w) scaled to `shape`."""
    if sums.shape[1:] == shape:
        return sums[:, slice(*(rows or (None,))), slice(*(columns or (None,)))]
    before, after, near, far = _between(sums.shape[2], shape[1], columns)
    wide = sums[:, :, before] * near + sums[:, :, after] * far
    before, after, near, far = _between(sums.shape[1], shape[0], rows)
    scaled: np.ndarray = wide[:, before] * near[:, None] + wide[:, after] * far[:, None]
    return scaled


def _between(size: int, to: int, part: tuple[int, int] | None) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """For each of the pixels `part` of `to` that `size` pixels are scaled to: the two that it lies between, and their weights."""
    pixels = np.arange(*(part or (0, to)), dtype=np.float32)
    one, half = np.float32(1), np.float32(0.5)
    at = np.maximum(np.float32(size) / np.float32(to) * (pixels + half) - half, np.float32(0))
    before = np.minimum(at.astype(np.int64), size - 1)
    far = at - before.astype(np.float32)
    return before, np.minimum(before + 1, size - 1), one - far, far
