"""From a frame to DualMap's observations: masks, their classes and features, and the clouds of every run."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ovman.agents.dualmap.classes import Classes
from ovman.agents.dualmap.dbscan import largest_cluster
from ovman.agents.dualmap.masks import filtered
from ovman.agents.dualmap.settings import DualmapObservation
from ovman.agents.dualmap.shot import FrameObject, Shot
from ovman.perception.backprojection import pixel_points
from ovman.perception.crop import squared
from ovman.perception.protocols import ImageTextEncoder, Segmenter, Segments
from ovman.sim.walk import Frame

EVERY_PX, HIGH = 4, 0.95
"""Stride in pixels and quantile of the height of a frame. Points above the quantile may be seen through a window."""


class Observer:
    """DualMap's observer.

    Pixel counts of the constants refer to a published frame and are scaled to the frame: in a smaller frame the smallest mask has
    proportionally fewer pixels, a larger share of its pixels is drawn, and the border of a crop is narrower. Clouds of an object
    are thus as dense in frames of all sizes.
    """

    def __init__(self, detector: Segmenter, encoder: ImageTextEncoder, constants: DualmapObservation) -> None:
        self._detector, self._encoder, self._constants = detector, encoder, constants
        self.classes = Classes.of(encoder, constants.mobility_margin, constants.low_mobility)

    def look(self, frames: Sequence[Frame], draws: Sequence[Sequence[np.random.Generator]]) -> list[Shot]:
        """The observations of each frame. draws: for each frame, one generator of pixels per run."""
        found = self._detector.detect([frame.rgb for frame in frames])
        looks = [self._clouded(*one) for one in zip(frames, found, draws, strict=True)]
        crops = [crop for look in looks for crop, *_ in look]
        named = iter(self._named(crops))
        return [
            Shot(tuple(FrameObject(*next(named), sure, clouds, mask) for _, sure, clouds, mask in look), _top_m(frame))
            for frame, look in zip(frames, looks, strict=True)
        ]

    def _clouded(
        self, frame: Frame, segments: Segments, runs: Sequence[np.random.Generator]
    ) -> list[tuple[np.ndarray, float, tuple[np.ndarray, ...], np.ndarray]]:
        """Crop, confidence, clouds and mask of every object of a frame that has a cloud in each run."""
        scale = frame.depth.size / self._constants.published_px
        share, border_px = min(self._constants.sample / scale, 1.0), round(self._constants.border_px * math.sqrt(scale))
        objects = []
        for which, own, whole in zip(
            *filtered(segments.masks, frame.rgb, self._constants.min_mask_px * scale, self._constants), strict=True
        ):
            clouds = self._clouds(frame, own, share, runs)
            if all(map(len, clouds)):
                objects.append((self._crop(frame.rgb, whole, border_px), float(segments.confidence[which]), clouds, own))
        return objects

    def _named(self, crops: Sequence[np.ndarray]) -> list[tuple[int, np.ndarray]]:
        """Class and feature (K,) of each crop."""
        if not crops:
            return []
        images = self._encoder.images(np.stack(crops))
        classes = (images @ self.classes.feature.T).argmax(axis=1)
        mixed = self._constants.image_weight * images + self._constants.text_weight * self.classes.feature[classes]
        features = mixed / np.linalg.norm(mixed, axis=1, keepdims=True)
        return list(zip(classes.tolist(), features.astype(np.float32), strict=True))

    def _clouds(
        self, frame: Frame, mask: np.ndarray, share: float, runs: Sequence[np.random.Generator]
    ) -> tuple[np.ndarray, ...]:
        """For each run, the largest cluster (N, 3) of the world points of a share of a mask's pixels; N may be 0."""
        inside = np.flatnonzero((mask & (frame.depth > 0)).ravel())  # several times as fast as nonzero of two axes
        drawn = [draw.choice(len(inside), int(share * len(inside)), replace=False, shuffle=False) for draw in runs]
        rows, columns = np.divmod(inside[np.concatenate(drawn)], mask.shape[1])
        points = pixel_points(frame.depth, rows, columns, frame.camera).astype(np.float32)
        radius_m, least = self._constants.cluster_radius_m, self._constants.cluster_points
        return tuple(part[largest_cluster(part, radius_m, least)] for part in np.split(points, len(drawn)))

    def _crop(self, rgb: np.ndarray, mask: np.ndarray, border_px: int) -> np.ndarray:
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        top, left = max(rows[0] - border_px, 0), max(columns[0] - border_px, 0)
        return squared(rgb[top : rows[-1] + border_px + 1, left : columns[-1] + border_px + 1], self._encoder.side_px)


def _top_m(frame: Frame) -> float:
    """Height of the top of a frame, metres, without outliers seen through windows."""
    rows, columns = (axis.ravel() for axis in np.mgrid[: frame.depth.shape[0] : EVERY_PX, : frame.depth.shape[1] : EVERY_PX])
    return float(np.quantile(pixel_points(frame.depth, rows, columns, frame.camera)[:, 1], HIGH))
