"""DualMap's saved maps: position and feature of every object, by run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from ovman.perception.array_file import read_arrays, write_arrays
from ovman.perception.clusters import ObjectMap

SCHEMA = "ovman-dualmap/3"
OBJECT = "object"
COLUMNS = ("position", "feature", "sort", "class_id", "first_seen", "last_seen")

Pair = tuple[str, str]
"""The names of a first and of a second visit."""


@dataclass(frozen=True, slots=True, eq=False)
class Mapped:
    """One saved map of N objects, at least one.

    Attributes:
        frames: Number of its keyframes.
        position: (N, 2) x and z of the centre of each box, metres.
        feature: (N, K) of unit length.
        sort: (N,) OBJECT in a local map; "anchor" or "related" in a global map of the released DualMap, whose maps have the same
            files.
        class_id: (N,) classes.
        first_seen: (N,) keyframes of the first observations.
        last_seen: (N,) keyframes of the last observations.
        members: Of each object the numbers of its observations among all of the map's dense tours, one after the other; empty if
            unknown.
    """

    frames: int
    position: np.ndarray
    feature: np.ndarray
    sort: np.ndarray
    class_id: np.ndarray
    first_seen: np.ndarray
    last_seen: np.ndarray
    members: tuple[np.ndarray, ...]

    def __len__(self) -> int:
        return len(self.position)

    def object_map(self) -> ObjectMap:
        """Return the map for the reference agent's rules. The track of an object is its one position."""
        tracks, last_seen = tuple(self.position[:, None]), tuple(self.last_seen.tolist())
        return ObjectMap(self.position, self.feature.astype(np.float64), tracks, last_seen, self.members)


@dataclass(frozen=True, slots=True)
class RunMaps:
    """The maps of a scene of one run. visits: of each visit by its name; maintained: of the two visits of each pair."""

    visits: Mapping[str, Mapped]
    maintained: Mapping[Pair, Mapped]


def write(path: Path, runs: Sequence[RunMaps]) -> None:
    """Write the maps of all runs of a scene, which have the same visits and pairs."""
    maps = [mapped for run in runs for mapped in (*run.visits.values(), *run.maintained.values())]
    members = [numbers for mapped in maps for numbers in mapped.members]
    known = np.array([len(numbers) for numbers in members], np.int64)
    arrays = {name: np.concatenate([getattr(mapped, name) for mapped in maps]) for name in COLUMNS}
    arrays |= {
        "feature": arrays["feature"].astype(np.float32),
        "runs": np.array(len(runs)),
        "visits": np.array(list(runs[0].visits), str),
        "pairs": np.array(list(runs[0].maintained), str).reshape(-1, 2),
        "frames": np.array([mapped.frames for mapped in maps], np.int64),
        "entries": np.array([len(mapped) for mapped in maps], np.int64),
        "observations": known,
        "known": known,
        "members": np.concatenate(members).astype(np.int32),
    }
    write_arrays(path, SCHEMA, arrays)


def read(path: Path) -> tuple[RunMaps, ...]:
    """Read the maps of all runs of a scene. Raises ArrayFileError for a damaged or other file."""
    arrays = read_arrays(path, SCHEMA)
    members = np.split(arrays["members"], np.cumsum(arrays["known"])[:-1])
    maps = iter(
        Mapped(frames, **{name: arrays[name][start:end] for name in COLUMNS}, members=tuple(members[start:end]))
        for frames, (start, end) in zip(arrays["frames"].tolist(), pairwise([0, *np.cumsum(arrays["entries"])]), strict=True)
    )
    visits, pairs = arrays["visits"].tolist(), [(first, second) for first, second in arrays["pairs"].tolist()]
    return tuple(
        RunMaps({name: next(maps) for name in visits}, {pair: next(maps) for pair in pairs}) for _ in range(int(arrays["runs"]))
    )
