"""What the perception leaves for others: detections, maps and nouns as .npz files without pickles.

Every file has a `schema`. Equal content has equal bytes. Imports no network library: who only reads maps starts fast.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ovman.perception.clusters import Cluster
from ovman.perception.detected import Detected, Masks

__all__ = [
    "Detected",
    "Masks",
    "RecordError",
    "read_arrays",
    "read_detections",
    "read_maps",
    "read_nouns",
    "write_arrays",
    "write_detections",
    "write_maps",
    "write_nouns",
]

DETECTIONS, MAPS, NOUNS = "ovman-detections/1", "ovman-maps/1", "ovman-nouns/1"
_ARRAYS = ("view", "point", "feature", "pixels", "confidence")


class RecordError(ValueError):
    """A file that is not what its schema says; one line with the file and the remedy."""


def write_detections(path: Path, visits: Mapping[str, Detected]) -> None:
    """Writes the detections of visits by their names."""
    arrays: dict[str, np.ndarray] = {"visits": np.array(list(visits), str)}
    for number, seen in enumerate(visits.values()):
        arrays |= {f"{number}.{name}": getattr(seen, name) for name in _ARRAYS}
        arrays[f"{number}.bits"] = seen.packed.bits()
        arrays[f"{number}.shape"] = np.array([seen.packed.height, seen.packed.width])
        arrays[f"{number}.content"] = np.array(seen.content)
    write_arrays(path, DETECTIONS, arrays, compressed=True)


def read_detections(path: Path) -> dict[str, Detected]:
    """The detections of visits by their names. RecordError for a file that is none of detections."""
    arrays = read_arrays(path, DETECTIONS, skip=".bits")

    def bits(number: int) -> Callable[[], np.ndarray]:
        def read() -> np.ndarray:
            with np.load(path) as file:
                return file[f"{number}.bits"]

        return read

    return {
        name: Detected(
            **{array: arrays[f"{number}.{array}"] for array in _ARRAYS},
            packed=Masks(*map(int, arrays[f"{number}.shape"]), bits(number)),
            content=str(arrays[f"{number}.content"]),
        )
        for number, name in enumerate(arrays["visits"].tolist())
    }


def write_maps(path: Path, maps: Mapping[str, Sequence[Cluster]]) -> None:
    """Writes the maps of visits by their names."""
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
    }
    write_arrays(path, MAPS, arrays)


def read_maps(path: Path) -> dict[str, tuple[Cluster, ...]]:
    """The maps of visits by their names: (p, f, T) of every cluster. RecordError for a file that is none of maps."""
    arrays = read_arrays(path, MAPS)
    ends = np.cumsum(arrays["points"])
    starts = (ends - arrays["points"]).tolist()
    track, views = arrays["track"], arrays["views"]
    every = [
        Cluster(position, feature, track[start:end], views[start:end])
        for position, feature, start, end in zip(arrays["position"], arrays["feature"], starts, ends.tolist(), strict=True)
    ]
    last = np.cumsum(arrays["clusters"]).tolist()
    return {
        name: tuple(every[end - count : end])
        for name, count, end in zip(arrays["visits"].tolist(), arrays["clusters"].tolist(), last, strict=True)
    }


def write_nouns(path: Path, nouns: Mapping[str, np.ndarray]) -> None:
    """Writes the embeddings (K,) of noun phrases."""
    write_arrays(path, NOUNS, {"nouns": np.array(list(nouns), str), "feature": np.array(list(nouns.values()), np.float32)})


def read_nouns(path: Path) -> dict[str, np.ndarray]:
    """The unit embedding (K,) of every noun phrase. RecordError for a file that is none of nouns."""
    arrays = read_arrays(path, NOUNS)
    return dict(zip(arrays["nouns"].tolist(), arrays["feature"], strict=True))


def write_arrays(path: Path, schema: str, arrays: Mapping[str, np.ndarray], compressed: bool = False) -> None:
    """Writes arrays without pickles under the name of what they are (`schema`), as numpy.savez does.

    Compressed is at the fastest level, which numpy does not offer: in less than half of its time to 105 % of its size.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    method = zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED
    with path.open("wb") as file:
        with zipfile.ZipFile(file, "w", method, compresslevel=1) as archive:
            for name, array in {"schema": np.array(schema), **arrays}.items():
                member = zipfile.ZipInfo(f"{name}.npy")
                member.compress_type = method
                with archive.open(member, "w", force_zip64=True) as to:
                    np.lib.format.write_array(to, np.asanyarray(array), allow_pickle=False)
        file.flush()
        os.fsync(file.fileno())


def read_arrays(path: Path, schema: str, skip: str | None = None) -> dict[str, np.ndarray]:
    """All arrays of a file but those whose name ends in `skip`. RecordError for a file that is none of `schema`."""
    try:
        with np.load(path) as file:
            found = str(file["schema"]) if "schema" in file else "nothing"
            wanted = [name for name in file.files if skip is None or not name.endswith(skip)] if found == schema else []
            arrays = {name: file[name] for name in wanted}
    except (zipfile.BadZipFile, ValueError, EOFError, AttributeError) as error:
        raise RecordError(f"{path}: no readable .npz file ({error}); remove it and make it again") from None
    if found != schema:
        raise RecordError(f"{path}: schema is {found}, not {schema}; remove the file and make it again")
    return arrays
