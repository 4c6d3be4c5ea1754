"""The runs of an evaluation on disk, plain or compressed."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, cast

from ovman.entry.errors import EntryError
from ovman.records.run import Score

RUNS = "runs.jsonl"
COMPRESSED = f"{RUNS}.gz"
LINE_BYTES = 1 << 20
"""A line is no longer: a file may come from anybody, and a compressed one may hold anything."""
LINES = 1_000_000
"""A file has no more."""


def runs_path(directory: Path) -> Path:
    """The file of the runs of an evaluation. EntryError where there is none, or both a plain and a compressed one."""
    there = [path for name in (RUNS, COMPRESSED) if (path := directory / name).is_file()]
    if not there:
        raise EntryError(f"{directory / RUNS}: there are no runs; an evaluation that was interrupted goes on by the same command")
    if len(there) > 1:
        raise EntryError(f"{directory}: holds {RUNS} and {COMPRESSED}; remove one of the two")
    return there[0]


def read_runs(path: Path) -> Iterator[tuple[str, Score]]:
    """The runs of a file, each with its place, "file:line". RecordError or EntryError, in one line, for what is none."""
    try:
        for number, text in enumerate(_lines(path), start=1):
            if number > LINES:
                raise EntryError(f"{path}: more than {LINES} lines; an evaluation has a line a run")
            place = f"{path}:{number}"
            if len(text) > LINE_BYTES:
                raise EntryError(f"{place}: more than {LINE_BYTES} bytes; a run has a few hundred")
            yield place, Score.parse(text.decode("utf-8", errors="replace"), place)
    except (OSError, EOFError, zlib.error) as error:
        raise EntryError(f"{path}: cannot be read ({error}); make the file again") from None


def compressed(content: bytes) -> bytes:
    """The content compressed; equal contents have equal bytes."""
    return gzip.compress(content, mtime=0)


def _lines(path: Path) -> Iterator[bytes]:
    """The lines of a file, of which one that is too long comes in pieces."""
    with cast(BinaryIO, gzip.open(path) if path.suffix == ".gz" else path.open("rb")) as file:
        while line := file.readline(LINE_BYTES + 1):
            yield line
