"""The detections of a tour as arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True, eq=False)
class PackedMasks:
    """N masks of a height and a width, one bit a pixel: `bits()` gives them as np.packbits does, (N, ceil(height * width / 8))
    uint8.
    """

    height: int
    width: int
    bits: Callable[[], np.ndarray]

    @staticmethod
    def of(masks: np.ndarray) -> PackedMasks:
        """The masks (N, H, W) bool."""
        count, height, width = masks.shape
        packed = np.packbits(masks.reshape(count, height * width), axis=1)
        return PackedMasks(height, width, lambda: packed)

    def unpacked(self) -> np.ndarray:
        """(N, H, W) bool."""
        bits = self.bits()
        flat = np.unpackbits(bits, axis=1, count=self.height * self.width)
        return flat.reshape(len(bits), self.height, self.width).astype(bool)


@dataclass(frozen=True, slots=True, eq=False)
class Detected:
    """The N detections of a tour, in the order of its views, and within a view by descending confidence.

    view (N,): index in the tour; point (N, 3): median of a mask's world points, metres; feature (N, K): unit embeddings of the
    crops; pixels (N,): sizes of the masks; confidence (N,) in [0, 1]; packed: the masks; content: digest of the tour's frames,
    its camera poses, the networks and their constants.
    """

    view: np.ndarray
    point: np.ndarray
    feature: np.ndarray
    pixels: np.ndarray
    confidence: np.ndarray
    packed: PackedMasks
    content: str

    def __len__(self) -> int:
        return len(self.view)

    def masks(self) -> np.ndarray:
        """(N, H, W) bool. Masks of a file are read from it at this call."""
        return self.packed.unpacked()
