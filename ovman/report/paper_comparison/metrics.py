"""The metrics as the page reads them: one number at a time, each knowing the file and the row that it comes from."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.report.cells import Record

# A value of theirs says nothing without the name of its column.
_BARE = frozenset({"seed", "instances"})


class Missing(LookupError):
    """A figure that the metrics do not have; the message says which, on one line. Where one is needed, nothing can be told."""


@dataclass(frozen=True, slots=True)
class Cell:
    """A finite number, and where it is from: "static_rates.csv (two_visits, all): rate"."""

    value: float
    source: str


class Metrics:
    """The csv files of results/metrics by the names of the files, without directory."""

    def __init__(self, files: Mapping[str, Sequence[Record]]) -> None:
        self._files = files

    @classmethod
    def read(cls, paths: Iterable[Path]) -> Metrics:
        """From csv files with a header. Raises ValueError in one line for a file without one."""
        files: dict[str, list[Record]] = {}
        for path in paths:
            with path.open(encoding="utf-8", newline="") as file:
                reader = csv.DictReader(file)
                if not reader.fieldnames:
                    raise ValueError(f"{path}: no header; make it again: snakemake {path}")
                files[path.name] = list(reader)
        return cls(files)

    def rows(self, file: str, **where: str) -> list[Record]:
        """The rows of a file in which each column of `where` has that very text.

        Raises Missing for a file or rows that there are not, ValueError for a column that the file has not.
        """
        if file not in self._files:
            raise Missing(f"there is no {file}")
        found = [row for row in self._files[file] if all(_text(file, row, column) == text for column, text in where.items())]
        if not found:
            raise Missing(f"{file} has no row of {_words(where)}" if where else f"{file} has no rows")
        return found

    def cell(self, file: str, column: str, **where: str) -> Cell:
        """The number in `column` of the one row that `where` names.

        Raises Missing where there is no such row or its cell is empty; ValueError in one line for two such rows, a column that
        the file has not, and what is no finite number.
        """
        found = self.rows(file, **where)
        if len(found) > 1:
            raise ValueError(f"{file}: {len(found)} rows of {_words(where)}, there must be one; make the metrics again")
        source = f"{file} ({_words(where)}): {column}"
        return Cell(_number(_text(file, found[0], column), source), source)

    def texts(self, file: str, column: str, **where: str) -> list[str]:
        """What the rows that `where` names have in `column`. Raises as ``rows`` does."""
        return [_text(file, row, column) for row in self.rows(file, **where)]

    def numbers(self, file: str, column: str, **where: str) -> list[float]:
        """The numbers in `column` of the rows that `where` names. Raises as ``cell`` does."""
        source = f"{file} ({_words(where)}): {column}"
        return [_number(text, source) for text in self.texts(file, column, **where)]


def _number(text: str, source: str) -> float:
    """A finite number. Raises Missing for no text, ValueError that names `source` for anything else."""
    if not text:
        raise Missing(f"{source} is empty")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{source} is {text!r}, which is no finite number; make the metrics again")
    return value


def _text(file: str, row: Record, column: str) -> str:
    text = row.get(column)
    if text is None:
        raise ValueError(f"{file}: no column {column}, there are {', '.join(map(str, row))}; make the metrics again")
    return text


def _words(where: Mapping[str, str]) -> str:
    return ", ".join(f"{column} {text}" if column in _BARE else text for column, text in where.items())
