"""DualMap's observations on dense tours, and their files. Imports no network library, so that reading starts fast.

A frame that dense tours of a scene share is stored once. Points are stored to the millimetre and unordered, features in half
precision.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from pathlib import Path

import numpy as np

from ovman.perception.array_file import read_arrays, write_arrays

WALKS = "ovman-walks/3"
MILLIMETRES = 1000.0
REACH_M = np.iinfo(np.int16).max / MILLIMETRES
SLICE_MM = 50
NO_VIEW = -1


@dataclass(frozen=True, slots=True, eq=False)
class FrameObject:
    """One object in a frame.

    Attributes:
        class_id: Index in the list of classes.
        feature: (K,) unit float32, a normalised mix of the embeddings of the crop and of the class name.
        confidence: Of the detector.
        clouds: Of every run, the points (N, 3) float32 that it drew of the mask's pixels, world frame, metres, N at least 1.
    """

    class_id: int
    feature: np.ndarray
    confidence: float
    clouds: tuple[np.ndarray, ...]

    @property
    def middle_m(self) -> float:
        """Height of the middle of the box of the points of all runs, metres."""
        heights = np.concatenate(self.clouds)[:, 1]
        middle: float = (heights.min() + heights.max()) / 2
        return middle


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """The objects in a frame, and the height of the frame's top, metres."""

    seen: tuple[FrameObject, ...]
    top_m: float


def pack_shots(shots: Sequence[Shot]) -> dict[str, np.ndarray]:
    """Return shots as arrays. Raises ValueError for points farther from the world's origin than REACH_M."""
    seen = [one for shot in shots for one in shot.seen]
    clouds = [cloud for one in seen for cloud in one.clouds]
    # One cloud at a time: a second copy of those of a large scene would be most of the memory of a job.
    ordered = [_order(_millimetres(cloud)) for cloud in clouds]
    return {
        "seen": np.array([len(shot.seen) for shot in shots], np.int32),
        "top_m": np.array([shot.top_m for shot in shots], np.float64),
        "class_id": np.array([one.class_id for one in seen], np.int16),
        "confidence": np.array([one.confidence for one in seen], np.float32),
        "feature": np.array([one.feature for one in seen], np.float16).reshape(len(seen), -1 if seen else 0),
        "clouds": np.array([len(one.clouds) for one in seen], np.int16),
        "points": np.array([len(cloud) for cloud in clouds], np.int32),
        "steps": _encode_steps(np.concatenate([np.zeros((0, 3), np.int16), *ordered])),
    }


def unpack_shots(arrays: Mapping[str, np.ndarray]) -> list[Shot]:
    """Return the shots of `pack_shots`, up to the precision of the arrays."""
    points = (_decode_steps(arrays["steps"]) / MILLIMETRES).astype(np.float32)
    clouds = [points[start:end] for start, end in _spans(arrays["points"])]
    features = arrays["feature"].astype(np.float32)
    features /= np.maximum(np.linalg.norm(features, axis=1, keepdims=True), np.finfo(np.float32).tiny)
    seen = [
        FrameObject(class_id, feature, confidence, tuple(clouds[start:end]))
        for class_id, confidence, feature, (start, end) in zip(
            arrays["class_id"].tolist(), arrays["confidence"].tolist(), features, _spans(arrays["clouds"]), strict=True
        )
    ]
    tops = arrays["top_m"].tolist()
    return [Shot(tuple(seen[start:end]), top) for (start, end), top in zip(_spans(arrays["seen"]), tops, strict=True)]


def _millimetres(cloud: np.ndarray) -> np.ndarray:
    """Return points (N, 3) in metres as int16 millimetres. Raises ValueError as `pack_shots`."""
    if np.abs(cloud).max(initial=0.0) > REACH_M:
        raise ValueError(f"a point lies farther than {REACH_M} m from the origin; no home is so large")
    millimetres: np.ndarray = np.rint(cloud * np.float32(MILLIMETRES)).astype(np.int16)
    return millimetres


def _order(cloud: np.ndarray) -> np.ndarray:
    """Order points (N, 3) int16 by layers, slices of a layer, and along a slice, so that neighbours follow each other."""
    x, y, z = cloud.T
    return cloud[np.lexsort((x, z // SLICE_MM, y // SLICE_MM))]


def _encode_steps(points: np.ndarray) -> np.ndarray:
    """Return differences of consecutive points (N, 3) int16 as (3, 2, N) uint8: zigzag-coded, low and high bytes apart.

    They compress to half the size of the points.
    """
    steps = np.diff(points.T, prepend=np.int16(0))
    folded = ((steps << 1) ^ (steps >> 15)).view(np.uint16)
    return np.stack([folded & 0xFF, folded >> 8], axis=1).astype(np.uint8)


def _decode_steps(steps: np.ndarray) -> np.ndarray:
    """Return the points of `_encode_steps`."""
    folded = steps[:, 0].astype(np.uint16) | steps[:, 1].astype(np.uint16) << 8
    differences = (folded >> 1) ^ -(folded & 1)
    return np.cumsum(differences.T.astype(np.int16), axis=0, dtype=np.int16)


def write_walks(
    path: Path, walks: Mapping[str, tuple[Sequence[int], Sequence[int]]], shots: Sequence[Shot], names: Sequence[str]
) -> None:
    """Write the dense tours of a scene by the names of their visits.

    walks: for each frame the index of its shot and of the recorded tour's view that it is, NO_VIEW between views; names: of the
    classes.
    """
    arrays = {
        "visits": np.array(list(walks), str),
        "frames": np.array([len(numbers) for numbers, _ in walks.values()], np.int32),
        "shot": np.array([number for numbers, _ in walks.values() for number in numbers], np.int32),
        "view": np.array([view for _, views in walks.values() for view in views], np.int16),
        "names": np.array(list(names), str),
        **pack_shots(shots),
    }
    write_arrays(path, WALKS, arrays, compressed=True)


@dataclass(frozen=True, slots=True)
class Walks:
    """The keyframes of a scene's dense tours by the names of their visits, and the number of classes."""

    keyframes: Mapping[str, Sequence[Sequence[FrameObject]]]
    kinds: int


def read_walks(path: Path) -> Walks:
    """Read the dense tours of a scene. Raises ArrayFileError for a damaged file or another kind."""
    arrays = read_arrays(path, WALKS)
    shots, numbers = unpack_shots(arrays), arrays["shot"].tolist()
    spans = zip(arrays["visits"].tolist(), _spans(arrays["frames"]), strict=True)
    return Walks({name: [shots[k].seen for k in numbers[start:end]] for name, (start, end) in spans}, len(arrays["names"]))


def _spans(counts: np.ndarray) -> list[tuple[int, int]]:
    """Return begin and end of consecutive parts with these numbers of entries."""
    return list(pairwise(accumulate(counts.tolist(), initial=0)))
