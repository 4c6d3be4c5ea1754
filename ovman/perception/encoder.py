"""Crops and noun phrases in one space: what stands around an image tower, and a table of phrases or a text tower."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.perception.graph import Network

KEY = "perception.encoder"
TOGETHER = 64
"""Batch size of crops and phrases."""
LANES = 8
"""Sums that a length is added up in."""
Texts = Callable[[Sequence[str]], np.ndarray]
"""Gives unit embeddings (N, K) float32 of N phrases."""


@dataclass(frozen=True, slots=True)
class EncoderFacts:
    """What preparing crops and reading embeddings needs of the towers.

    side_px: of the crops; size: K of the embeddings; mean and deviation (3,): normalisation of pictures.
    """

    side_px: int
    size: int
    mean: tuple[float, ...]
    deviation: tuple[float, ...]


class Encoder:
    """Two towers with their preprocessing.

    tower: for crops (N, 3, side_px, side_px) it gives embeddings (N, K), of any length. side_px: of the crops; size: K.
    """

    def __init__(self, tower: Network, facts: EncoderFacts, texts: Texts) -> None:
        self.tower, self._texts = tower, texts
        self.side_px, self.size = facts.side_px, facts.size
        self._mean, self._deviation = (np.array(of, np.float32).reshape(1, 3, 1, 1) for of in (facts.mean, facts.deviation))

    def images(self, crops: np.ndarray) -> np.ndarray:
        """Unit embeddings (N, K) float32 of crops (N, side_px, side_px, 3) uint8 RGB."""
        parts = [crops[start : start + TOGETHER] for start in range(0, len(crops), TOGETHER)]
        found = [unit(self.tower(self.prepared(part))[0]) for part in parts]
        return np.concatenate([np.zeros((0, self.size), np.float32), *found])

    def prepared(self, crops: np.ndarray) -> np.ndarray:
        """What the tower takes: (N, 3, side_px, side_px) float32, normalised."""
        pictures = np.ascontiguousarray(crops.transpose(0, 3, 1, 2)).astype(np.float32)
        pictures /= np.float32(255)
        pictures -= self._mean
        pictures /= self._deviation
        return pictures

    def texts(self, phrases: Sequence[str]) -> np.ndarray:
        """Unit embeddings (N, K) float32 of noun phrases. WeightsError for one without an embedding."""
        return self._texts(phrases) if len(phrases) else np.zeros((0, self.size), np.float32)


def unit(features: np.ndarray) -> np.ndarray:
    """Features (N, K) float32 as unit vectors. Squares are added up in LANES sums, in float32 and in torch's order."""
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
