"""Find class-agnostic instance masks in pictures, with a network that gives boxes and mask prototypes.

A picture is scaled into a frame (`Letterbox`); boxes that overlap too much are suppressed; a mask is where a weighted sum of the
prototypes, scaled to the picture, is positive within its box. The arithmetic gives the numbers of torch and torchvision.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from ovman.perception.graph import Network

KEY = "perception.detector"
AT_MOST = 100
"""Most instances of a picture."""
OVERLAP = 0.7
"""Greatest IoU of two boxes that both stay."""
GREY = 114
"""Value of the padding of a frame, as in the training."""
FINER = 4
"""Pixels of a frame on a side of a prototype's pixel."""


@dataclass(frozen=True, slots=True, eq=False)
class Detections:
    """The N instances of one picture by descending confidence. masks: (N, H, W) bool; confidence: (N,) in [0, 1]."""

    masks: np.ndarray
    confidence: np.ndarray


@dataclass(frozen=True, slots=True)
class DetectorFacts:
    """Facts of a network that preparing pictures and reading outputs need.

    stride: divides the sides of its frames; end2end: whether it suppresses overlaps itself; classes: number of its scores.
    """

    stride: int
    end2end: bool
    classes: int


class Detector:
    """A segmentation network, used class-agnostically: overlaps are suppressed over all classes together."""

    def __init__(self, network: Network, facts: DetectorFacts, side_px: int, confidence: float) -> None:
        """Wrap a network.

        Args:
            network: Gives boxes and mask prototypes (1, C, H / 4, W / 4) for a frame (1, 3, H, W). Boxes are
                (1, 4 + classes + C, N): centre, size, scores and mask coefficients; of a network that suppresses overlaps
                (1, N, 6 + C): corners, score, class and coefficients.
            facts: Of the network.
            side_px: Pictures are scaled to this side.
            confidence: Threshold of an instance.
        """
        self.network, self._facts, self.side_px, self._confidence = network, facts, side_px, np.float32(confidence)
        self._at = {side_px: self}

    def at(self, side_px: int) -> Detector:
        """Return the same network with pictures scaled to another side, a multiple of 32."""
        if side_px not in self._at:
            self._at[side_px] = Detector(self.network, self._facts, side_px, float(self._confidence))
        return self._at[side_px]

    def detect(self, pictures: Sequence[np.ndarray]) -> list[Detections]:
        """Find the instances of pictures (H, W, 3) uint8 RGB, each alone, so that none depends on another."""
        return [self._detect(picture) for picture in pictures]

    def _detect(self, picture: np.ndarray) -> Detections:
        height, width = picture.shape[:2]
        letterbox = Letterbox.of(height, width, self.side_px, self._facts.stride)
        boxes, prototypes = (output[0] for output in self.network(letterbox.frame_of(picture)))
        corners, confidence, coefficients = self._select(boxes, len(prototypes))
        found = build_masks(coefficients, prototypes, letterbox.to_picture(corners), letterbox)
        shown = found.any(axis=(1, 2))
        return Detections(found[shown], confidence[shown])

    def _select(self, boxes: np.ndarray, coefficients: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return corners (N, 4), confidence (N,) and mask coefficients (N, `coefficients`) of the boxes that stay."""
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


@dataclass(frozen=True, slots=True)
class Letterbox:
    """The place of a picture of height and width `shape` in the frame that a network is given.

    scaled: (height, width) of the picture in the frame; top, left: rows and columns of grey before it; frame: (height, width) of
    the frame.
    """

    shape: tuple[int, int]
    scaled: tuple[int, int]
    top: int
    left: int
    frame: tuple[int, int]

    @staticmethod
    def of(height: int, width: int, side_px: int, stride: int) -> Letterbox:
        """Return the frame of a picture whose longer side is scaled to `side_px`, a multiple of `stride`."""
        gain = min(side_px / height, side_px / width)
        scaled = max(round(height * gain), 1), max(round(width * gain), 1)
        rows, columns = ((side_px - size) % stride for size in scaled)
        # Of an odd number of grey rows, one more is below.
        return Letterbox((height, width), scaled, rows // 2, columns // 2, (scaled[0] + rows, scaled[1] + columns))

    def frame_of(self, picture: np.ndarray) -> np.ndarray:
        """Return the frame (1, 3, H, W) float32 in [0, 1] of a picture (height, width, 3) uint8 RGB."""
        height, width = self.scaled
        if self.scaled != self.shape:
            picture = cv2.resize(picture, (width, height), interpolation=cv2.INTER_LINEAR)
        frame = np.full((1, 3, *self.frame), GREY, np.float32)
        frame[0, :, self.top : self.top + height, self.left : self.left + width] = picture.transpose(2, 0, 1)
        frame /= np.float32(255)
        return frame

    def to_picture(self, corners: np.ndarray) -> np.ndarray:
        """Return boxes (N, 4) float32 of the frame, as corners x, y, x, y, in pixels of the picture and within it."""
        (height, width), (rows, columns) = self.shape, self.scaled
        offset = np.array([self.left, self.top] * 2, np.float32)
        gain = np.array([columns / width, rows / height] * 2, np.float32)
        within: np.ndarray = ((corners - offset) / gain).clip(0, np.array([width, height] * 2, np.float32))
        return within


def non_max_suppression(boxes: np.ndarray, confidence: np.ndarray, iou_threshold: float, at_most: int) -> np.ndarray:
    """Return the indices of at most `at_most` kept boxes by descending confidence; ties stay in the order of the boxes.

    boxes: (N, 4) float32, corners x, y, x, y with the smaller coordinates first. A box is kept if its IoU with every kept box of
    higher confidence is at most `iou_threshold`. The result equals torchvision's `nms`, whose import takes two seconds.
    """
    order = np.argsort(-confidence, kind="stable")
    left, top, right, bottom = boxes[order].T
    area = (right - left) * (bottom - top)
    stay: list[int] = []
    waiting = np.arange(len(order))
    while len(waiting) and len(stay) < at_most:
        first, waiting = waiting[0], waiting[1:]
        stay.append(first)
        width = np.minimum(right[first], right[waiting]) - np.maximum(left[first], left[waiting])
        height = np.minimum(bottom[first], bottom[waiting]) - np.maximum(top[first], top[waiting])
        shared = np.maximum(width, 0) * np.maximum(height, 0)
        with np.errstate(invalid="ignore"):
            overlap = shared / (area[first] + area[waiting] - shared)
        waiting = waiting[~(overlap > np.float64(iou_threshold))]
    kept: np.ndarray = order[np.array(stay, int)]
    return kept


def build_masks(coefficients: np.ndarray, prototypes: np.ndarray, boxes: np.ndarray, letterbox: Letterbox) -> np.ndarray:
    """Return the masks (N, height, width) bool of a picture.

    coefficients: (N, C) float32. prototypes: (C, H, W) float32 of the frame. boxes: (N, 4) of the picture, as corners x, y, x, y.
    The scaling is bilinear, in float32, and in the order of torch's `interpolate`, whose signs it gives.
    """
    count, height, width = prototypes.shape
    sums = (coefficients @ prototypes.reshape(count, -1)).reshape(-1, height, width)
    around = [FINER * size - scaled for size, scaled in zip((height, width), letterbox.scaled, strict=True)]
    padding = around[0] | around[1]
    factor = FINER // math.gcd(FINER, padding | padding // 2)  # at which the grey around the picture ends between two pixels
    if factor > 1:
        sums = _scale(sums, (height * factor, width * factor))
    sums = _cut_grey(sums, letterbox)
    found = np.zeros((len(boxes), *letterbox.shape), bool)
    for mask, logits, (left, top, right, bottom) in zip(found, sums, np.ceil(boxes).astype(int), strict=True):
        # A pixel counts from the box's first side on and before its last one.
        mask[top:bottom, left:right] = _scale(logits[None], letterbox.shape, (top, bottom), (left, right))[0] > 0
    return found


def _cut_grey(sums: np.ndarray, letterbox: Letterbox) -> np.ndarray:
    sizes, shape = sums.shape[1:], letterbox.shape
    gain = min(size / side for size, side in zip(sizes, shape, strict=True))
    content = [max(round(side * gain), 1) for side in shape]
    top, left = (round((size - inner) / 2 - 0.1) for size, inner in zip(sizes, content, strict=True))
    return sums[:, top : top + content[0], left : left + content[1]]


def _scale(
    sums: np.ndarray, shape: tuple[int, int], rows: tuple[int, int] | None = None, columns: tuple[int, int] | None = None
) -> np.ndarray:
    """Return the part `rows` by `columns` (all if not given) of sums (N, h, w) scaled to `shape`."""
    if sums.shape[1:] == shape:
        return sums[:, slice(*(rows or (None,))), slice(*(columns or (None,)))]
    before, after, near, far = _interpolate(sums.shape[2], shape[1], columns)
    wide = sums[:, :, before] * near + sums[:, :, after] * far
    before, after, near, far = _interpolate(sums.shape[1], shape[0], rows)
    scaled: np.ndarray = wide[:, before] * near[:, None] + wide[:, after] * far[:, None]
    return scaled


def _interpolate(size: int, to: int, part: tuple[int, int] | None) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the two pixels around each of the pixels `part` of `to`, which `size` pixels are scaled to, and their weights."""
    pixels = np.arange(*(part or (0, to)), dtype=np.float32)
    one, half = np.float32(1), np.float32(0.5)
    at = np.maximum(np.float32(size) / np.float32(to) * (pixels + half) - half, np.float32(0))
    before = np.minimum(at.astype(np.int64), size - 1)
    far = at - before.astype(np.float32)
    return before, np.minimum(before + 1, size - 1), one - far, far
