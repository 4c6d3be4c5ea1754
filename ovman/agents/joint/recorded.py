"""The segments of recorded tours as a file of arrays (`ovman.perception.array_file`)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ovman.agents.interface import Visit
from ovman.agents.joint.segments import Segments
from ovman.perception.array_file import read_arrays, write_arrays

SCHEMA = "ovman-segments/1"
Tours = tuple[str, str]
"""What the first and the second tour show (`Visit.content`), since names of visits reveal the change."""
Weighed = Mapping[Tours, tuple[Segments, Segments]]


def of_tours(every: Weighed, first: Visit, second: Visit) -> tuple[Segments, Segments]:
    """The segments of two tours. ValueError for tours that were not weighed against each other."""
    contents = str(first.content), str(second.content)
    if contents not in every:
        raise ValueError(f"no segments of the tours with the contents {' and '.join(contents)}; make the stage segments again")
    return every[contents]


def write(path: Path, every: Weighed) -> None:
    """Writes the segments of pairs of tours."""
    parts = [segments for pair in every.values() for segments in pair]
    counts = np.array([len(part) for part in parts], np.int64)
    arrays = {"tours": np.array(list(every), str).reshape(len(every), 2), "counts": counts}
    for name in Segments.__slots__ if parts else ():
        values = np.concatenate([getattr(part, name) for part in parts])
        arrays[name] = values.astype(np.float32) if name == "feature" else values
    write_arrays(path, SCHEMA, arrays)


def read(path: Path) -> dict[Tours, tuple[Segments, Segments]]:
    """The segments of pairs of tours. ArrayFileError for a damaged file or one of another kind."""
    arrays = read_arrays(path, SCHEMA)
    ends = np.cumsum(arrays["counts"]).tolist()
    starts = [0, *ends]
    arrays["feature"] = arrays["feature"].astype(np.float64) if ends else np.zeros((0, 0))
    parts = [
        Segments(**{name: arrays[name][start:end] for name in Segments.__slots__})
        for start, end in zip(starts[:-1], ends, strict=True)
    ]
    return {(first, second): (parts[2 * k], parts[2 * k + 1]) for k, (first, second) in enumerate(arrays["tours"].tolist())}
