"""DualMap's saved maps: position and feature of every object, by run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import numpy as np

from ovman.agents.dualmap.local_map import MapObject
from ovman.perception.array_file import ArrayFileError, read_arrays, write_arrays
from ovman.perception.clusters import ObjectMap

SCHEMA = "ovman-dualmap/3"

Pair = tuple[str, str]
"""The names of a first and of a second visit."""


class Sort(StrEnum):
    """OBJECT: of a local map. ANCHOR, RELATED: of a global map of the released DualMap, whose maps have the same files."""

    OBJECT = "object"
    ANCHOR = "anchor"
    RELATED = "related"


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """An object of a saved map.

    Attributes:
        position: (2,) x and z of the centre of its box, metres.
        feature: (K,) of unit length.
        sort: Kind of the map that it is of.
        class_id: Its class.
        observations: Number of its observations.
        first_seen: Keyframe of the map.
        last_seen: Keyframe of the map.
        members: (M,) numbers of its observations among all of the map's dense tours, one after the other; empty if unknown.
    """

    position: np.ndarray
    feature: np.ndarray
    sort: Sort
    class_id: int
    observations: int
    first_seen: int
    last_seen: int
    members: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))

    @staticmethod
    def of_object(thing: MapObject, frames: int = 0, observations: int = 0) -> Entry:
        """Return an object of a local map, after a first dense tour of so many keyframes and observations."""
        return Entry(
            thing.position,
            thing.feature,
            Sort.OBJECT,
            thing.class_id,
            len(thing.seen),
            thing.first_seen,
            thing.last_seen,
            thing.members(frames, observations),
        )


@dataclass(frozen=True, slots=True)
class Mapped:
    """One saved map. frames: number of its keyframes."""

    entries: tuple[Entry, ...]
    frames: int

    def object_map(self) -> ObjectMap:
        """Return the map for the reference agent's rules.

        A track is the one position of an object; last_seen its last keyframe.
        """
        entries = self.entries
        return ObjectMap(
            p=np.array([e.position for e in entries], dtype=np.float64).reshape(-1, 2),
            f=np.array([e.feature for e in entries], dtype=np.float64) if entries else np.zeros((0, 0)),
            tracks=tuple(np.asarray(e.position, dtype=np.float64)[None] for e in entries),
            last_seen=tuple(e.last_seen for e in entries),
            members=tuple(e.members for e in entries),
        )


@dataclass(frozen=True, slots=True)
class RunMaps:
    """The maps of a scene of one run. visits: of each visit by its name; maintained: of the two visits of each pair."""

    visits: Mapping[str, Mapped]
    maintained: Mapping[Pair, Mapped]


def write(path: Path, runs: Sequence[RunMaps]) -> None:
    """Write the maps of all runs of a scene. Raises ValueError unless all runs have the same visits and pairs."""
    visits, pairs = list(runs[0].visits), list(runs[0].maintained)
    if any(list(run.visits) != visits or list(run.maintained) != pairs for run in runs):
        raise ValueError("runs of a scene have maps of the same visits and pairs")
    maps = [mapped for run in runs for mapped in (*run.visits.values(), *run.maintained.values())]
    every = [entry for mapped in maps for entry in mapped.entries]
    size = len(every[0].feature) if every else 0
    arrays = {
        "runs": np.array(len(runs)),
        "visits": np.array(visits, str),
        "pairs": np.array(pairs, str).reshape(-1, 2),
        "frames": np.array([mapped.frames for mapped in maps], np.int64),
        "entries": np.array([len(mapped.entries) for mapped in maps], np.int64),
        "position": np.array([e.position for e in every], np.float64).reshape(-1, 2),
        "feature": np.array([e.feature for e in every], np.float32).reshape(len(every), size),
        "sort": np.array([e.sort for e in every], str),
    }
    arrays["known"] = np.array([len(e.members) for e in every], np.int64)
    arrays["members"] = np.concatenate([np.zeros(0, np.int64), *(e.members for e in every)]).astype(np.int32)
    for name in ("class_id", "observations", "first_seen", "last_seen"):
        arrays[name] = np.array([getattr(e, name) for e in every], np.int64)
    write_arrays(path, SCHEMA, arrays)


def read(path: Path) -> tuple[RunMaps, ...]:
    """Read the maps of all runs of a scene. Raises ArrayFileError for a missing, damaged or other file."""
    try:
        arrays = read_arrays(path, SCHEMA)
    except FileNotFoundError:
        raise ArrayFileError(f"{path} is missing; make the stage dualmap") from None
    known = np.cumsum(arrays["known"]).tolist()
    members = [arrays["members"][end - count : end] for end, count in zip(known, arrays["known"].tolist(), strict=True)]
    rows = zip(
        arrays["position"],
        arrays["feature"],
        arrays["sort"].tolist(),
        *(arrays[name].tolist() for name in ("class_id", "observations", "first_seen", "last_seen")),
        members,
        strict=True,
    )
    every = [Entry(position, feature, Sort(sort), *rest) for position, feature, sort, *rest in rows]
    ends = np.cumsum(arrays["entries"]).tolist()
    maps = [
        Mapped(tuple(every[end - count : end]), frames)
        for end, count, frames in zip(ends, arrays["entries"].tolist(), arrays["frames"].tolist(), strict=True)
    ]
    visits, pairs = arrays["visits"].tolist(), [(first, second) for first, second in arrays["pairs"].tolist()]
    each = len(visits) + len(pairs)
    return tuple(
        RunMaps(
            dict(zip(visits, maps[run * each :][: len(visits)], strict=True)),
            dict(zip(pairs, maps[run * each + len(visits) :][: len(pairs)], strict=True)),
        )
        for run in range(int(arrays["runs"]))
    )
