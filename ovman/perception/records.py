"""Detections, maps and noun embeddings, and their files of arrays (`ovman.perception.array_file`).

The module imports no network library, so that a process that only reads maps starts fast.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ovman.perception.array_file import read_array, read_arrays, write_arrays
from ovman.perception.clusters import Cluster

DETECTIONS, MAPS, NOUNS = "ovman-detections/2", "ovman-maps/3", "ovman-nouns/2"
_ARRAYS = ("view", "point", "feature", "pixels", "confidence")


@dataclass(frozen=True, slots=True, eq=False)
class Detected:
    """The N detections of a tour, in the order of its views, and within a view by descending confidence.

    view (N,): index in the tour; point (N, 3): median of a mask's world points, metres; feature (N, K): unit embeddings of the
    crops; pixels (N,): sizes of the masks; confidence (N,) in [0, 1]; masks: returns them, (N, H, W) bool; masks of a file are
    read from it at the call; content: digest of the tour's frames, its camera poses, the networks and their constants.
    """

    view: np.ndarray
    point: np.ndarray
    feature: np.ndarray
    pixels: np.ndarray
    confidence: np.ndarray
    masks: Callable[[], np.ndarray]
    content: str

    def __len__(self) -> int:
        return len(self.view)


def keep_masks(masks: np.ndarray) -> Callable[[], np.ndarray]:
    """Return a function that returns masks (N, H, W) bool, which it keeps as one bit per pixel."""
    bits, shape = _pack(masks), masks.shape[1:]
    return lambda: _unpack(bits, shape)


def _pack(masks: np.ndarray) -> np.ndarray:
    return np.packbits(masks.reshape(len(masks), math.prod(masks.shape[1:])), axis=1)


def _unpack(bits: np.ndarray, shape: Sequence[int]) -> np.ndarray:
    return np.unpackbits(bits, axis=1, count=math.prod(shape)).reshape(len(bits), *shape).astype(bool)


def write_detections(path: Path, visits: Mapping[str, Detected]) -> None:
    """Write the detections of visits by their names."""
    arrays: dict[str, np.ndarray] = {"visits": np.array(list(visits), str)}
    for number, seen in enumerate(visits.values()):
        arrays |= {f"{number}.{name}": getattr(seen, name) for name in _ARRAYS}
        masks = seen.masks()
        arrays[f"{number}.bits"], arrays[f"{number}.shape"] = _pack(masks), np.array(masks.shape[1:])
        arrays[f"{number}.content"] = np.array(seen.content)
    write_arrays(path, DETECTIONS, arrays, compressed=True)


def read_detections(path: Path) -> dict[str, Detected]:
    """Read the detections of visits by their names. Raises ArrayFileError for a damaged file or one of another kind."""
    arrays = read_arrays(path, DETECTIONS, skip=".bits")

    def read_masks(number: int) -> np.ndarray:
        return _unpack(read_array(path, f"{number}.bits"), arrays[f"{number}.shape"].tolist())

    return {
        name: Detected(
            **{array: arrays[f"{number}.{array}"] for array in _ARRAYS},
            masks=partial(read_masks, number),
            content=str(arrays[f"{number}.content"]),
        )
        for number, name in enumerate(arrays["visits"].tolist())
    }


def name_pair(first: str, second: str) -> str:
    """Return the name under which a file has the one map of two visits."""
    return f"{first} and {second}"


def write_maps(path: Path, maps: Mapping[str, Sequence[Cluster]]) -> None:
    """Write the maps of visits by their names."""
    every = [cluster for found in maps.values() for cluster in found]
    size = len(every[0].feature) if every else 0
    arrays = {
        "visits": np.array(list(maps), str),
        "clusters": np.array([len(found) for found in maps.values()], np.int64),
        "position": np.array([c.position for c in every], np.float64).reshape(len(every), 2),
        "feature": np.array([c.feature for c in every], np.float32).reshape(len(every), size),
        "points": np.array([len(c.track) for c in every], np.int64),
        "track": np.concatenate([np.zeros((0, 2)), *(c.track for c in every)]),
        "views": np.concatenate([np.zeros(0, np.int64), *(c.views for c in every)]).astype(np.int64),
        "members": np.concatenate([np.zeros(0, np.int64), *(_members(c) for c in every)]).astype(np.int64),
    }
    write_arrays(path, MAPS, arrays)


def read_maps(path: Path) -> dict[str, tuple[Cluster, ...]]:
    """Read the maps of visits by their names: (p, f, T) of every cluster. Raises ArrayFileError as `read_detections`."""
    arrays = read_arrays(path, MAPS)
    ends = np.cumsum(arrays["points"])
    starts = (ends - arrays["points"]).tolist()
    track, views, members = arrays["track"], arrays["views"], arrays["members"]
    every = [
        Cluster(position, feature, track[start:end], views[start:end], _known(members[start:end]))
        for position, feature, start, end in zip(arrays["position"], arrays["feature"], starts, ends.tolist(), strict=True)
    ]
    last = np.cumsum(arrays["clusters"]).tolist()
    return {
        name: tuple(every[end - count : end])
        for name, count, end in zip(arrays["visits"].tolist(), arrays["clusters"].tolist(), last, strict=True)
    }


_UNKNOWN = -1


def _members(cluster: Cluster) -> np.ndarray:
    return cluster.members if len(cluster.members) else np.full(len(cluster.track), _UNKNOWN)


def _known(members: np.ndarray) -> np.ndarray:
    known: np.ndarray = members[members != _UNKNOWN]
    return known


def write_nouns(path: Path, nouns: Mapping[str, np.ndarray]) -> None:
    """Write the embeddings (K,) of noun phrases."""
    write_arrays(path, NOUNS, {"nouns": np.array(list(nouns), str), "feature": np.array(list(nouns.values()), np.float32)})


def read_nouns(path: Path) -> dict[str, np.ndarray]:
    """Read the unit embedding (K,) of every noun phrase. Raises ArrayFileError as `read_detections`."""
    arrays = read_arrays(path, NOUNS)
    return dict(zip(arrays["nouns"].tolist(), arrays["feature"], strict=True))
