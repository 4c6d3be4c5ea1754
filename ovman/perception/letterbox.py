"""A picture as a detector takes it: scaled to its side, with grey around it up to the next multiple of its stride."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

GREY = 114
"""Value of the padding, as in the training."""


@dataclass(frozen=True, slots=True)
class Letterbox:
    """Where a picture of height and width `shape` lies in the frame that a network is shown.

    scaled: (height, width) of the picture in the frame; top, left: rows and columns of grey before it; frame: (height, width) of
    all.
    """

    shape: tuple[int, int]
    scaled: tuple[int, int]
    top: int
    left: int
    frame: tuple[int, int]

    @staticmethod
    def of(height: int, width: int, side_px: int, stride: int) -> Letterbox:
        """The frame of a picture whose longer side is scaled to `side_px`, a multiple of `stride`."""
        gain = min(side_px / height, side_px / width)
        scaled = max(round(height * gain), 1), max(round(width * gain), 1)
        rows, columns = ((side_px - size) % stride for size in scaled)
        # Of an odd number of grey rows, one more stands below.
        return Letterbox((height, width), scaled, rows // 2, columns // 2, (scaled[0] + rows, scaled[1] + columns))

    def framed(self, picture: np.ndarray) -> np.ndarray:
        """The frame (1, 3, H, W) float32 in [0, 1] of a picture (height, width, 3) uint8 RGB."""
        height, width = self.scaled
        if self.scaled != self.shape:
            picture = cv2.resize(picture, (width, height), interpolation=cv2.INTER_LINEAR)
        frame = np.full((1, 3, *self.frame), GREY, np.float32)
        frame[0, :, self.top : self.top + height, self.left : self.left + width] = picture.transpose(2, 0, 1)
        frame /= np.float32(255)
        return frame

    def boxes(self, corners: np.ndarray) -> np.ndarray:
        """Boxes (N, 4) float32 of the frame, as corners x, y, x, y, in pixels of the picture and within it."""
        (height, width), (rows, columns) = self.shape, self.scaled
        offset = np.array([self.left, self.top] * 2, np.float32)
        gain = np.array([columns / width, rows / height] * 2, np.float32)
        within: np.ndarray = ((corners - offset) / gain).clip(0, np.array([width, height] * 2, np.float32))
        return within
