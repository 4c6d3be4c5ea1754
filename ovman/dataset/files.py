"""The Parquet files of the data set: one a table and split, and of tours one a floor plan."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class DataFile:
    """name: relative to the folder of the data set; rows: how many it has; size: bytes; sha256: hexadecimal."""

    name: str
    table: str
    split: str
    rows: int
    size: int
    sha256: str


def data_file(folder: Path, name: str, table: str, split: str, rows: int) -> DataFile:
    """Of a file that was written."""
    return DataFile(name, table, split, rows, (folder / name).stat().st_size, sha256(folder / name))


def sha256(path: Path) -> str:
    """Of a file's content, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
