"""Training data of the encoder: crops of recorded pictures around roughened true masks and around detected ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ovman.perception import networks
from ovman.perception.detector import Detector
from ovman.perception.encoder import crop
from ovman.perception.labels import LEAST_IOU, intersection_over_union
from ovman.seeds import generator
from ovman.settings import Settings
from training.pictures import Picture, RecordedPicture, list_pictures, read_pictures

MIN_MASK_PX = 300
"""Smallest true mask in the training data, as the agent's smallest."""
BATCH = 16
"""Pictures that a detector is given at once."""
CONTRAST = 0.25
"""Contrast that is left outside of a mask: context stays, and a rough mask does not hide its object."""
WAVE, GROWN, SHIFT_PX, PIECES = 0.035, 0.015, 0.7, 6
"""Standard deviations of a mask's outline, locally and as a whole, as shares of its size; of its shift; waves along a side."""
CUT, CUT_SHARE = 0.25, (0.05, 0.3)
"""Share of the masks that a neighbour cuts, and the parts that it takes."""


@dataclass(frozen=True, slots=True, eq=False)
class Crops:
    """N crops.

    images: (N, S, S, 3) uint8; types: (N,) by AI2-THOR's names; colours: (N, 3) mean of the mask's pixels, 0 to 255; pixels:
    (N,) of the masks; scenes: (N,).
    """

    images: np.ndarray
    types: np.ndarray
    colours: np.ndarray
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
    """Write the crops of a recorded scene around its true masks, roughened."""
    rng = generator(settings.training.seed, "crops", folder.name)
    shown = list_pictures([folder])[: settings.training.encoder.views]
    _write(folder.name, ((p, roughen(p.ids == n, rng), n) for p, n in _true_masks(shown)), settings, output)


def run_detected(folders: Sequence[Path], settings: Settings, outputs: Sequence[Path]) -> None:
    """Write the crops of recorded scenes around the masks of the detector of the settings, one file per scene."""
    detector = networks.detector_of(settings.perception)
    for folder, output in zip(folders, outputs, strict=True):
        shown = list_pictures([folder])[: settings.training.encoder.views]
        _write(folder.name, _detected_masks(shown, detector, settings.perception.detector.min_mask_px), settings, output)


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


def roughen(mask: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a mask (H, W) bool as a detector might find it: its outline waves, so that thin parts are lost and holes appear.

    It is shifted, grown or shrunk, and some are cut as by a neighbour; never empty. Its median IoU with the true one is .87.
    """
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    size = math.sqrt(np.count_nonzero(mask))
    margin = round(0.2 * size) + 2
    box = slice(max(y - margin, 0), y + height + margin), slice(max(x - margin, 0), x + width + margin)
    inner = mask[box].astype(np.uint8)
    depth = cv2.distanceTransform(inner, cv2.DIST_L2, 3) - cv2.distanceTransform(1 - inner, cv2.DIST_L2, 3)
    waves = cv2.resize(rng.standard_normal((PIECES, PIECES)), inner.shape[::-1], interpolation=cv2.INTER_CUBIC)
    move = np.array([[1, 0, rng.normal(0, SHIFT_PX)], [0, 1, rng.normal(0, SHIFT_PX)]])
    moved: np.ndarray = cv2.warpAffine(depth, move, inner.shape[::-1], borderMode=cv2.BORDER_REPLICATE)
    rough: np.ndarray = moved + size * (WAVE * waves + rng.normal(0, GROWN)) > 0
    if rng.random() < CUT and rough.any():
        angle, share = rng.uniform(0, 2 * math.pi), rng.uniform(*CUT_SHARE)
        rows, columns = np.indices(rough.shape)
        along = np.asarray(math.cos(angle) * columns + math.sin(angle) * rows)
        rough &= along >= np.quantile(along[rough], share)
    found = np.zeros_like(mask)
    found[box] = rough if rough.any() else inner > 0
    return found


def _true_masks(recorded: Sequence[RecordedPicture]) -> Iterator[tuple[Picture, int]]:
    for picture in read_pictures(recorded):
        for number in np.flatnonzero(picture.sizes() >= MIN_MASK_PX).tolist():
            yield picture, number


def _detected_masks(
    recorded: Sequence[RecordedPicture], detector: Detector, min_mask_px: int
) -> Iterator[tuple[Picture, np.ndarray, int]]:
    for picture, masks, overlaps, _ in match_detections(detector, recorded, min_mask_px):
        for mask, row in zip(masks, overlaps, strict=True):
            if row.max(initial=0.0) >= LEAST_IOU:
                yield picture, mask, int(row.argmax())


def _write(scene: str, shown: Iterator[tuple[Picture, np.ndarray, int]], settings: Settings, output: Path) -> None:
    cv2.setNumThreads(1)
    side_px, padding = settings.training.encoder.crop_px, settings.perception.encoder.crop_padding
    rows = [
        (crop(p.rgb, mask, padding, side_px, CONTRAST), p.objects[n].type, p.rgb[mask].mean(axis=0), int(mask.sum()), scene)
        for p, mask, n in shown
    ]
    if rows:
        found = Crops(*(np.array(column) for column in zip(*rows, strict=True)))
    else:
        names = np.zeros(0, "<U1")
        found = Crops(np.zeros((0, side_px, side_px, 3), np.uint8), names, np.zeros((0, 3)), np.zeros(0, np.int64), names)
    found.write(output)
    print(f"{scene}: {len(found.types)} crops", flush=True)
