"""Training data of the encoder: crops of recorded pictures around true and around detected masks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ovman.perception import networks, yolo
from ovman.perception.crop import crop
from ovman.perception.overlap import LEAST_IOU
from ovman.perception.protocols import Segmenter
from ovman.settings import Settings
from ovman.training.picture_files import read, recorded
from ovman.training.pictures import Picture
from ovman.training.seen import seen

MIN_MASK_PX = 150
"""Smallest true mask in the training data; the agent encodes larger ones only."""


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
    def joined(parts: Sequence[Crops]) -> Crops:
        """The concatenation of several."""
        return Crops(*(np.concatenate([getattr(part, name) for part in parts]) for name in Crops.__slots__))

    @staticmethod
    def read(path: Path) -> Crops:
        """The crops of a file of `write`."""
        with np.load(path) as arrays:
            return Crops(*(arrays[name] for name in Crops.__slots__))

    def write(self, path: Path) -> None:
        """Write an .npz file."""
        with path.open("wb") as file:
            np.savez(file, **{name: getattr(self, name) for name in Crops.__slots__})


def true_crops(folder: Path, padding: float, side_px: int) -> Crops:
    """Crops around the true masks of a recorded scene."""
    return _crops(folder.name, _true(folder), padding, side_px)


def detected_crops(folder: Path, detector: Segmenter, min_mask_px: int, padding: float, side_px: int, every: int = 1) -> Crops:
    """Crops around detected masks that show an instance, in one of `every` pictures."""
    return _crops(folder.name, _detected(folder, detector, min_mask_px, every), padding, side_px)


def run_true(folder: Path, constants: Settings, output: Path) -> None:
    """Writes the crops of a recorded scene around its true masks."""
    made = true_crops(folder, constants.perception.encoder.crop_padding, constants.training.encoder.crop_px)
    made.write(output)
    print(f"{folder.name}: {len(made.types)} crops", flush=True)


def run_detected(folders: Sequence[Path], weights: Path, constants: Settings, outputs: Sequence[Path]) -> None:
    """Writes the crops of recorded scenes around the masks of the detector with these weights, one file a scene."""
    import torch

    torch.set_num_threads(1)
    settings, padding = constants.perception.detector, constants.perception.encoder.crop_padding
    training = constants.training.encoder
    network = yolo.network_of(weights, settings.architecture)
    detector = networks.loaded_detector(network, weights, settings.side_px, settings.confidence)
    for folder, output in zip(folders, outputs, strict=True):
        made = detected_crops(folder, detector, settings.min_mask_px, padding, training.crop_px, training.detected_one_in)
        made.write(output)
        print(f"{folder.name}: {len(made.types)} crops", flush=True)


def _true(folder: Path) -> Iterator[tuple[Picture, np.ndarray, int]]:
    for picture in read(recorded([folder])):
        sizes = np.bincount(picture.ids[picture.ids >= 0], minlength=len(picture.objects))
        for number in np.flatnonzero(sizes >= MIN_MASK_PX).tolist():
            yield picture, picture.ids == number, number


def _detected(folder: Path, detector: Segmenter, min_mask_px: int, every: int) -> Iterator[tuple[Picture, np.ndarray, int]]:
    for picture, masks, overlaps, _ in seen(detector, recorded([folder], every), min_mask_px):
        for mask, row in zip(masks, overlaps, strict=True):
            if row.max(initial=0.0) >= LEAST_IOU:
                yield picture, mask, int(row.argmax())


def _crops(scene: str, shown: Iterator[tuple[Picture, np.ndarray, int]], padding: float, side_px: int) -> Crops:
    cv2.setNumThreads(1)
    rows = []
    for picture, mask, number in shown:
        thing = picture.objects[number]
        rows.append(
            (
                crop(picture.rgb, mask, padding, side_px),
                thing.type,
                "|".join(thing.materials),
                picture.rgb[mask].mean(axis=0),
                thing.size_m,
                int(mask.sum()),
                scene,
            )
        )
    if not rows:
        empty = np.zeros(0, "<U1")
        images = np.zeros((0, side_px, side_px, 3), np.uint8)
        return Crops(images, empty, empty, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, np.int64), empty)
    return Crops(*(np.array(column) for column in zip(*rows, strict=True)))
