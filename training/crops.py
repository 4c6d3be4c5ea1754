"""Training data of the encoder: crops of recorded pictures around true and around detected masks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ovman.perception import networks, pytorch
from ovman.perception.detector import Detector
from ovman.perception.encoder import crop
from ovman.perception.labels import LEAST_IOU, intersection_over_union
from ovman.settings import Settings
from training.pictures import Picture, RecordedPicture, list_pictures, read_pictures

MIN_MASK_PX = 150
"""Smallest true mask in the training data; the agent encodes larger ones only."""
BATCH = 16
"""Pictures that a detector is given at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Crops:
    """N crops.

    images: (N, S, S, 3) uint8; types, materials ("Wood|Metal"): (N,) by AI2-THOR's names; colours: (N, 3) mean of the mask's
    pixels, 0 to 255; sizes_m: (N, 3) of the instances' boxes; pixels: (N,) of the masks; scenes: (N,).
    """

    images: np.ndarray
    types: np.ndarray
    materials: np.ndarray
    colours: np.ndarray
    sizes_m: np.ndarray
    pixels: np.ndarray
    scenes: np.ndarray

    @staticmethod
    def join(parts: Sequence[Crops]) -> Crops:
        """Concatenate several."""
        return Crops(*(np.concatenate([getattr(part, name) for part in parts]) for name in Crops.__slots__))

    @staticmethod
    def read(path: Path) -> Crops:
        """Read the crops of a file of `write`."""
        with np.load(path) as arrays:
            return Crops(*(arrays[name] for name in Crops.__slots__))

    def write(self, path: Path) -> None:
        """Write an .npz file."""
        with path.open("wb") as file:
            np.savez(file, **{name: getattr(self, name) for name in Crops.__slots__})


def run_true(folder: Path, settings: Settings, output: Path) -> None:
    """Write the crops of a recorded scene around its true masks."""
    crops = true_crops(folder, settings.perception.encoder.crop_padding, settings.training.encoder.crop_px)
    crops.write(output)
    print(f"{folder.name}: {len(crops.types)} crops", flush=True)


def run_detected(folders: Sequence[Path], weights: Path, settings: Settings, outputs: Sequence[Path]) -> None:
    """Write the crops of recorded scenes around the masks of the detector with these weights, one file per scene."""
    import torch

    torch.set_num_threads(1)
    detection, padding, training = settings.perception.detector, settings.perception.encoder.crop_padding, settings.training
    network = pytorch.load_detector(weights, detection.architecture)
    detector = networks.loaded_detector(network, detection.side_px, detection.confidence)
    for folder, output in zip(folders, outputs, strict=True):
        shown = _detected_masks(folder, detector, detection.min_mask_px, training.encoder.detected_one_in)
        crops = _cut(folder.name, shown, padding, training.encoder.crop_px)
        crops.write(output)
        print(f"{folder.name}: {len(crops.types)} crops", flush=True)


def true_crops(folder: Path, padding: float, side_px: int) -> Crops:
    """Return the crops around the true masks of a recorded scene."""
    return _cut(folder.name, _true_masks(folder), padding, side_px)


def match_detections(
    detector: Detector, recorded: Sequence[RecordedPicture], min_mask_px: int
) -> Iterator[tuple[Picture, np.ndarray, np.ndarray, np.ndarray]]:
    """Compare what a detector finds in recorded pictures with their true instances.

    Yields:
        Per picture: the picture, the detected masks (N, H, W) of at least `min_mask_px`, their IoU (N, K) with its objects, and
        these objects' sizes (K,) in pixels.
    """
    for start in range(0, len(recorded), BATCH):
        pictures = list(read_pictures(recorded[start : start + BATCH]))
        for picture, found in zip(pictures, detector.detect([p.rgb for p in pictures]), strict=True):
            masks = found.masks[found.masks.sum(axis=(1, 2)) >= min_mask_px]
            yield picture, masks, *intersection_over_union(masks, picture.ids, len(picture.objects))


def _true_masks(folder: Path) -> Iterator[tuple[Picture, np.ndarray, int]]:
    for picture in read_pictures(list_pictures([folder])):
        for number in np.flatnonzero(picture.sizes() >= MIN_MASK_PX).tolist():
            yield picture, picture.ids == number, number


def _detected_masks(folder: Path, detector: Detector, min_mask_px: int, every: int) -> Iterator[tuple[Picture, np.ndarray, int]]:
    for picture, masks, overlaps, _ in match_detections(detector, list_pictures([folder], every), min_mask_px):
        for mask, row in zip(masks, overlaps, strict=True):
            if row.max(initial=0.0) >= LEAST_IOU:
                yield picture, mask, int(row.argmax())


def _cut(scene: str, shown: Iterator[tuple[Picture, np.ndarray, int]], padding: float, side_px: int) -> Crops:
    cv2.setNumThreads(1)
    rows = []
    for picture, mask, number in shown:
        thing = picture.objects[number]
        image, colour = crop(picture.rgb, mask, padding, side_px), picture.rgb[mask].mean(axis=0)
        rows.append((image, thing.type, "|".join(thing.materials), colour, thing.size_m, int(mask.sum()), scene))
    if not rows:
        empty = np.zeros(0, "<U1")
        images = np.zeros((0, side_px, side_px, 3), np.uint8)
        return Crops(images, empty, empty, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, np.int64), empty)
    return Crops(*(np.array(column) for column in zip(*rows, strict=True)))
