"""Embed crops and noun phrases in one space, with an image tower and a text tower."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from ovman.perception.graph import Network

KEY = "perception.encoder"
TOGETHER = 64
"""Batch size of crops and phrases."""
LANES = 8
"""Partial sums of a length."""
GREY = 127
"""Value of the padding of a crop."""
Texts = Callable[[Sequence[str]], np.ndarray]
"""Gives unit embeddings (N, K) float32 of N phrases."""


@dataclass(frozen=True, slots=True)
class EncoderFacts:
    """Facts of the towers that preparing crops and reading embeddings need.

    side_px: of the crops; size: K of the embeddings; mean and deviation (3,): normalisation of pictures; contrast: of what a mask
    leaves out of its crop, 1 if it stays as it is; texts: SHA-256 of the graph of the text tower, "" if the weights have it.
    """

    side_px: int
    size: int
    mean: tuple[float, ...]
    deviation: tuple[float, ...]
    contrast: float = 1.0
    texts: str = ""


class Encoder:
    """Two towers with their preprocessing. side_px, contrast: of the crops; size: K of the embeddings."""

    def __init__(self, tower: Network, facts: EncoderFacts, texts: Texts) -> None:
        """Wrap towers. tower: gives embeddings (N, K), of any length, for crops (N, 3, side_px, side_px)."""
        self.tower, self._texts = tower, texts
        self.side_px, self.size, self.contrast = facts.side_px, facts.size, facts.contrast
        self._mean, self._deviation = (np.array(of, np.float32).reshape(1, 3, 1, 1) for of in (facts.mean, facts.deviation))

    def images(self, crops: np.ndarray) -> np.ndarray:
        """Return unit embeddings (N, K) float32 of crops (N, side_px, side_px, 3) uint8 RGB."""
        parts = [crops[start : start + TOGETHER] for start in range(0, len(crops), TOGETHER)]
        found = [unit(self.tower(self.prepare(part))[0]) for part in parts]
        return np.concatenate([np.zeros((0, self.size), np.float32), *found])

    def prepare(self, crops: np.ndarray) -> np.ndarray:
        """Return the input of the tower: (N, 3, side_px, side_px) float32, normalised."""
        pictures = np.ascontiguousarray(crops.transpose(0, 3, 1, 2)).astype(np.float32)
        pictures /= np.float32(255)
        pictures -= self._mean
        pictures /= self._deviation
        return pictures

    def texts(self, phrases: Sequence[str]) -> np.ndarray:
        """Return unit embeddings (N, K) float32 of noun phrases. Raises WeightsError for a phrase without an embedding."""
        return self._texts(phrases) if len(phrases) else np.zeros((0, self.size), np.float32)


def unit(features: np.ndarray) -> np.ndarray:
    """Scale features (N, K) float32 to unit length. Squares are added in LANES partial sums, in float32 and in torch's order."""
    squares = np.zeros((len(features), -(-features.shape[1] // LANES), LANES), np.float32)
    squares.reshape(len(features), -1)[:, : features.shape[1]] = features * features
    lanes = np.zeros((len(features), LANES), np.float32)
    for step in range(squares.shape[1]):
        lanes += squares[:, step]
    total = lanes[:, 0].copy()
    for lane in range(1, LANES):
        total += lanes[:, lane]
    found: np.ndarray = features / np.maximum(np.sqrt(total), np.float32(1e-12))[:, None]
    return found


def crop(rgb: np.ndarray, mask: np.ndarray, pad: float, side_px: int, contrast: float = 1.0) -> np.ndarray:
    """Return a square crop (side_px, side_px, 3) uint8 of rgb (H, W, 3) around mask (H, W) bool.

    The mask's box is grown by the fraction `pad` of its longer side on every side and cut at the picture's edges; what the mask
    leaves out is faded to grey down to `contrast`; padding with grey makes it square without stretching. Raises ValueError for an
    empty mask.
    """
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        raise ValueError("an empty mask has no crop")
    grown = round(pad * max(rows[-1] - rows[0], columns[-1] - columns[0]) + 1)
    top, left = max(rows[0] - grown, 0), max(columns[0] - grown, 0)
    box = slice(top, rows[-1] + grown + 1), slice(left, columns[-1] + grown + 1)
    return pad_to_square(fade(rgb[box], mask[box], contrast), side_px)


def fade(part: np.ndarray, mask: np.ndarray, contrast: float) -> np.ndarray:
    """Return a part (H, W, 3) uint8 of a picture in which what the mask (H, W) leaves out has only this contrast to grey."""
    if contrast == 1:
        return part
    faded = cv2.LUT(part, _fade_values(contrast))
    return cv2.copyTo(part, mask.view(np.uint8), faded)


@cache
def _fade_values(contrast: float) -> np.ndarray:
    """Return the values (256,) uint8 that the values of a channel fade to."""
    values: np.ndarray = np.rint(GREY + contrast * (np.arange(256) - GREY)).astype(np.uint8)
    return values


def pad_to_square(part: np.ndarray, side_px: int) -> np.ndarray:
    """Scale a part (H, W, 3) uint8 of a picture to fit into (side_px, side_px, 3) and pad it with grey."""
    scale = side_px / max(part.shape[:2])
    height, width = (max(round(n * scale), 1) for n in part.shape[:2])
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    square = np.full((side_px, side_px, 3), GREY, np.uint8)
    y, x = (side_px - height) // 2, (side_px - width) // 2
    square[y : y + height, x : x + width] = cv2.resize(part, (width, height), interpolation=method)
    return square
