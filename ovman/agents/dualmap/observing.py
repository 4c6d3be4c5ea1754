"""From a frame to DualMap's observations: masks, their classes and features, and the clouds of every run."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from ovman.agents.dualmap import DualmapObservation
from ovman.agents.dualmap.cloud import find_largest_clusters
from ovman.agents.dualmap.observations import FrameObject, Shot
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS
from ovman.perception.backprojection import pixel_points
from ovman.perception.detector import Detections, Detector
from ovman.perception.encoder import Encoder, fade, pad_to_square
from ovman.sim.walk import Frame

EVERY_PX, HIGH = 4, 0.95
"""Stride in pixels and quantile of the height of a frame. Points above the quantile may be seen through a window."""


class Observer:
    """DualMap's observer: from a frame to observations.

    Pixel counts of the constants refer to a published frame and are scaled to the frame: in a smaller frame the smallest mask has
    proportionally fewer pixels, a larger share of its pixels is drawn, and the border of a crop is narrower. Clouds of an object
    are thus as dense in frames of all sizes.
    """

    def __init__(self, detector: Detector, encoder: Encoder, constants: DualmapObservation) -> None:
        self._detector, self._encoder, self._constants = detector, encoder, constants
        # The noun of every category of the floor plans. The list is complete, so that it needs no class "unknown".
        self.classes = tuple(noun(category) for category in SYNONYMS)
        self.class_features = encoder.texts(self.classes)

    def look(
        self, frames: Sequence[Frame], draws: Sequence[Sequence[np.random.Generator]]
    ) -> list[tuple[Shot, list[np.ndarray]]]:
        """Return the observations of each frame, and their masks (H, W). draws: for each frame, one generator per run."""
        found = self._detector.detect([frame.rgb for frame in frames])
        looks = [self._find_objects(*one) for one in zip(frames, found, draws, strict=True)]
        crops = [crop for look in looks for crop, *_ in look]
        named = iter(self._classify(crops))
        return [
            (
                Shot(tuple(FrameObject(*next(named), sure, clouds) for _, sure, clouds, _ in look), _top_m(frame)),
                [mask for *_, mask in look],
            )
            for frame, look in zip(frames, looks, strict=True)
        ]

    def _find_objects(
        self, frame: Frame, segments: Detections, runs: Sequence[np.random.Generator]
    ) -> list[tuple[np.ndarray, float, tuple[np.ndarray, ...], np.ndarray]]:
        """Return crop, confidence, clouds and mask of every object of a frame that has a cloud in each run."""
        scale = frame.depth.size / self._constants.published_px
        share, border_px = min(self._constants.sample / scale, 1.0), round(self._constants.border_px * math.sqrt(scale))
        kept = filter_masks(segments.masks, frame.rgb, self._constants.min_mask_px * scale, self._constants)
        objects = []
        for which, own, whole, clouds in zip(*kept, self._make_clouds(frame, kept[1], share, runs), strict=True):
            if all(map(len, clouds)):
                objects.append((self._crop(frame.rgb, whole, border_px), float(segments.confidence[which]), clouds, own))
        return objects

    def _classify(self, crops: Sequence[np.ndarray]) -> list[tuple[int, np.ndarray]]:
        """Return the class and the feature (K,) of each crop."""
        if not crops:
            return []
        images = self._encoder.images(np.stack(crops))
        classes = (images @ self.class_features.T).argmax(axis=1)
        mixed = self._constants.image_weight * images + self._constants.text_weight * self.class_features[classes]
        features = mixed / np.linalg.norm(mixed, axis=1, keepdims=True)
        return list(zip(classes.tolist(), features.astype(np.float32), strict=True))

    def _make_clouds(
        self, frame: Frame, masks: np.ndarray, share: float, runs: Sequence[np.random.Generator]
    ) -> list[tuple[np.ndarray, ...]]:
        """Return for each mask and run the largest cluster (N, 3) of the world points of a share of its pixels; N may be 0."""
        clouds: list[np.ndarray] = []
        for mask in masks:
            inside = np.flatnonzero((mask & (frame.depth > 0)).ravel())  # several times as fast as nonzero of two axes
            drawn = [draw.choice(len(inside), int(share * len(inside)), replace=False, shuffle=False) for draw in runs]
            rows, columns = np.divmod(inside[np.concatenate(drawn)], mask.shape[1])
            clouds += np.split(pixel_points(frame.depth, rows, columns, frame.camera).astype(np.float32), len(drawn))
        found = find_largest_clusters(clouds, self._constants.cluster_radius_m, self._constants.cluster_points)
        largest = [cloud[indices] for cloud, indices in zip(clouds, found, strict=True)]
        return [tuple(largest[start : start + len(runs)]) for start in range(0, len(largest), len(runs))]

    def _crop(self, rgb: np.ndarray, mask: np.ndarray, border_px: int) -> np.ndarray:
        x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
        box = tuple(slice(max(at - border_px, 0), at + side + border_px) for at, side in ((y, height), (x, width)))
        return pad_to_square(fade(rgb[box], mask[box], self._encoder.contrast), self._encoder.side_px)


def _top_m(frame: Frame) -> float:
    """Return the height of the top of a frame, metres, without outliers seen through windows."""
    rows, columns = (axis.ravel() for axis in np.mgrid[: frame.depth.shape[0] : EVERY_PX, : frame.depth.shape[1] : EVERY_PX])
    return float(np.quantile(pixel_points(frame.depth, rows, columns, frame.camera)[:, 1], HIGH))


# Masks ------------------------------------------------------------------------------------------------------------------------


def histogram(colours: np.ndarray, bins: int) -> np.ndarray:
    """Count pixels (N, 3) uint8 in equal bins of each channel, one channel after the other: (3 * bins,)."""
    binned = (np.arange(256) * bins // 256)[colours.T]
    return np.concatenate([np.bincount(channel, minlength=bins) for channel in binned]).astype(float)


def filter_masks(
    masks: np.ndarray, rgb: np.ndarray, min_mask_px: float, constants: DualmapObservation
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Filter the masks (N, H, W) bool of a picture rgb (H, W, 3): no duplicates, none too small, disjoint.

    The steps: drop masks below min_mask_px pixels; of duplicates keep the larger; merge a mask into a larger one of the same
    colours that it overlaps; give remaining overlaps to the smaller mask; drop masks that are then below min_mask_px.

    Returns:
        Their indices (M,), the disjoint masks (M, H, W) bool, and the same masks before overlaps were removed.
    """
    least, sizes = max(min_mask_px, 1), np.count_nonzero(masks, axis=(1, 2))
    kept = np.flatnonzero(sizes >= least)
    kept = kept[np.argsort(-sizes[kept], kind="stable")]
    masks = masks[kept]
    flat = masks.reshape(len(masks), rgb.shape[0] * rgb.shape[1]).astype(np.float32)
    shared = (flat @ flat.T).astype(np.int64)  # float32 counts exactly up to 16 million pixels
    alone = _without_duplicates(shared, constants.same_iou)
    whole, kept = _merge(masks[alone], kept[alone], shared[np.ix_(alone, alone)], rgb, constants)
    own, taken = whole.copy(), np.zeros(rgb.shape[:2], bool)
    for mask in own[::-1]:
        mask &= ~taken
        taken |= mask
    enough = np.count_nonzero(own, axis=(1, 2)) >= least
    return kept[enough], own[enough], whole[enough]


def _without_duplicates(shared: np.ndarray, same_iou: float) -> np.ndarray:
    """Return the indices of the masks, the largest first, that duplicate no larger kept one. shared: (N, N) common pixels."""
    sizes, kept = np.diag(shared), np.zeros(0, np.int64)
    for i, size in enumerate(sizes):
        union = sizes[kept] + size - shared[i, kept]
        if not (shared[i, kept] > same_iou * union).any():
            kept = np.append(kept, i)
    return kept


def _merge(
    masks: np.ndarray, kept: np.ndarray, shared: np.ndarray, rgb: np.ndarray, constants: DualmapObservation
) -> tuple[np.ndarray, np.ndarray]:
    """Return masks (M, H, W), the largest first, after merging masks into larger ones, and their indices."""
    masks = masks.copy()
    histograms = [histogram(rgb[mask], constants.colour_bins) for mask in masks]
    gone: set[int] = set()
    for i, j in np.argwhere(np.triu(shared > 0, 1)).tolist():
        if i in gone or j in gone:
            continue
        a, b = histograms[i], histograms[j]
        if a @ b > constants.same_colours * np.sqrt((a @ a) * (b @ b)):
            masks[i] |= masks[j]
            gone.add(j)
    left = [i for i in range(len(masks)) if i not in gone]
    order = sorted(left, key=lambda i: -np.count_nonzero(masks[i]))
    return masks[order], kept[order]
