"""Cues of appearance that no arm uses: colours and extent of every detection, with the true instance that it shows.

The file is the evaluator's, as it names true instances.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path

import cv2
import numpy as np

from ovman.perception.array_file import read_arrays, write_arrays

CUES = "ovman-cues/1"
HUES, SATURATIONS = 180, 256
"""Values of the hue and the saturation of a pixel of 8 bit, as OpenCV has them."""


@dataclass(frozen=True, slots=True, eq=False)
class Cues:
    """The N detections of a tour, in their order.

    histogram (N, B): of the mask's hues and saturations, each sums to 1; extent (N, 3): `backprojection.extents`, metres; pixels
    (N,): sizes of the masks; instance (N,): the true instance that the mask shows as an index into `instances`, -1 if it overlaps
    with no instance enough.
    """

    instances: tuple[str, ...]
    histogram: np.ndarray
    extent: np.ndarray
    pixels: np.ndarray
    instance: np.ndarray

    def __len__(self) -> int:
        return len(self.instance)


_ARRAYS = tuple(field.name for field in fields(Cues) if field.name != "instances")


def colour_histograms(rgb: np.ndarray, masks: np.ndarray, hue_bins: int, saturation_bins: int) -> np.ndarray:
    """Return hue-saturation histograms (N, hue_bins * saturation_bins) float32 of masks (N, H, W) of a picture (H, W, 3) uint8.

    Bins have equal width; the saturation's bins of a hue are adjacent. Each histogram sums to 1; that of an empty mask is 0.
    """
    hsv = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2HSV).astype(np.int64).reshape(-1, 3)
    cells = hsv[:, 0] * hue_bins // HUES * saturation_bins + hsv[:, 1] * saturation_bins // SATURATIONS
    flat = masks.reshape(len(masks), len(cells))
    counts = [np.bincount(cells[np.flatnonzero(mask)], minlength=hue_bins * saturation_bins) for mask in flat]
    found = np.array(counts, np.float64).reshape(len(masks), hue_bins * saturation_bins)
    shares: np.ndarray = (found / np.maximum(found.sum(axis=1, keepdims=True), 1)).astype(np.float32)
    return shares


def write_cues(path: Path, visits: Mapping[str, Cues]) -> None:
    """Write the cues of visits by their names. A tour that several visits share is written once, if they share the object."""
    every = list({id(cues): cues for cues in visits.values()}.values())
    number = {id(cues): n for n, cues in enumerate(every)}
    arrays = {
        "visits": np.array(list(visits), str),
        "tour": np.array([number[id(cues)] for cues in visits.values()], np.int64),
    }
    for n, cues in enumerate(every):
        arrays |= {f"{n}.{name}": getattr(cues, name) for name in _ARRAYS}
        arrays[f"{n}.instances"] = np.array(cues.instances, str)
    write_arrays(path, CUES, arrays, compressed=True)


def read_cues(path: Path) -> dict[str, Cues]:
    """Read the cues of visits by their names. Raises ArrayFileError for a damaged file or one of another kind."""
    arrays = read_arrays(path, CUES)
    tours = [
        Cues(tuple(arrays[f"{n}.instances"].tolist()), **{name: arrays[f"{n}.{name}"] for name in _ARRAYS})
        for n in range(1 + max(arrays["tour"].tolist(), default=-1))
    ]
    return {name: tours[n] for name, n in zip(arrays["visits"].tolist(), arrays["tour"].tolist(), strict=True)}
