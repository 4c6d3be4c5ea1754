"""Class-agnostic instance masks of pictures: what stands around a network that gives boxes and mask prototypes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.perception.graph import Network
from ovman.perception.letterbox import Letterbox
from ovman.perception.non_max_suppression import non_max_suppression
from ovman.perception.prototypes import masks

KEY = "perception.detector"
AT_MOST = 100
"""Most instances of a picture."""
OVERLAP = 0.7
"""Greatest IoU of two boxes that both stay."""


@dataclass(frozen=True, slots=True, eq=False)
class Detections:
    """The N instances of one picture by descending confidence. masks: (N, H, W) bool; confidence: (N,) in [0, 1]."""

    masks: np.ndarray
    confidence: np.ndarray


@dataclass(frozen=True, slots=True)
class DetectorFacts:
    """What preparing pictures and reading outputs needs of a network.

    stride: divides the sides of its frames; end2end: it suppresses overlaps itself; classes: number of its scores.
    """

    stride: int
    end2end: bool
    classes: int


class Detector:
    """A segmentation network, used class-agnostically: overlaps are suppressed over all classes together.

    network: for a frame (1, 3, H, W) it gives boxes and mask prototypes (1, C, H / 4, W / 4). Boxes are (1, 4 + classes + C, N):
    centre, size, scores and mask coefficients; of a network that suppresses overlaps (1, N, 6 + C): corners, score, class and
    coefficients.
    side_px: pictures are scaled to this side; confidence: threshold of an instance.
    """

    def __init__(self, network: Network, facts: DetectorFacts, side_px: int, confidence: float) -> None:
        self.network, self._facts, self.side_px, self._confidence = network, facts, side_px, np.float32(confidence)
        self._at = {side_px: self}

    def at(self, side_px: int) -> Detector:
        """The same network with pictures scaled to another side, a multiple of 32."""
        if side_px not in self._at:
            self._at[side_px] = Detector(self.network, self._facts, side_px, float(self._confidence))
        return self._at[side_px]

    def detect(self, pictures: Sequence[np.ndarray]) -> list[Detections]:
        """The instances of pictures (H, W, 3) uint8 RGB; each goes through the network alone, so that none depends on another."""
        return [self._detected(picture) for picture in pictures]

    def _detected(self, picture: np.ndarray) -> Detections:
        height, width = picture.shape[:2]
        letterbox = Letterbox.of(height, width, self.side_px, self._facts.stride)
        boxes, prototypes = (output[0] for output in self.network(letterbox.framed(picture)))
        corners, confidence, coefficients = self._kept(boxes, len(prototypes))
        found = masks(coefficients, prototypes, letterbox.boxes(corners), letterbox)
        shown = found.any(axis=(1, 2))
        return Detections(found[shown], confidence[shown])

    def _kept(self, boxes: np.ndarray, coefficients: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Corners (N, 4), confidence (N,) and mask coefficients (N, `coefficients`) of the boxes that stay."""
        if self._facts.end2end:
            sure = boxes[boxes[:, 4] > self._confidence][:AT_MOST]
            return sure[:, :4], sure[:, 4], sure[:, 6:]
        end = len(boxes) - coefficients
        sure = boxes[:, boxes[4:end].max(axis=0) > self._confidence].T
        half = sure[:, 2:4] / 2
        corners = np.concatenate((sure[:, :2] - half, sure[:, :2] + half), axis=1)
        confidence = sure[:, 4:end].max(axis=1)
        stay = non_max_suppression(corners, confidence, OVERLAP, AT_MOST)
        return corners[stay], confidence[stay], sure[stay, end:]
