"""Interfaces of networks that perception and agents use. `Detector` and `Encoder` have them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np


class Segments(Protocol):
    """The N instances of one picture by descending confidence: `ovman.perception.detector.Detections`."""

    @property
    def masks(self) -> np.ndarray:
        """(N, H, W) bool."""

    @property
    def confidence(self) -> np.ndarray:
        """(N,) in [0, 1]."""


class Segmenter(Protocol):
    """Finds instances in pictures: `ovman.perception.detector.Detector`."""

    def detect(self, pictures: Sequence[np.ndarray]) -> Sequence[Segments]:
        """Find the instances of each picture (H, W, 3) uint8 RGB."""


class ImageEncoder(Protocol):
    """Embeds crops."""

    @property
    def side_px(self) -> int:
        """Side of the crops."""

    def images(self, crops: np.ndarray) -> np.ndarray:
        """Return unit embeddings (N, K) float32 of crops (N, side_px, side_px, 3) uint8 RGB."""


class TextEncoder(Protocol):
    """Embeds phrases."""

    def texts(self, phrases: Sequence[str]) -> np.ndarray:
        """Return unit embeddings (N, K) float32 of N phrases."""


class ImageTextEncoder(ImageEncoder, TextEncoder, Protocol):
    """Embeds crops and phrases in one space: `ovman.perception.encoder.Encoder`."""
