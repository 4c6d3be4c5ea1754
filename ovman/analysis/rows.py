"""Rows of metrics read from csv files, without data frames: a reader of a few rows does not import pandas."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, TypeVar, get_args, get_type_hints

RowType = TypeVar("RowType")


def read_rows(path: Path, kind: type[RowType], arms: Collection[str] | None = None) -> list[RowType]:
    """The rows of a file of metrics as the dataclass `kind`, a column a field, in the order of the file.

    Empty text is None where a field may be None. arms: only rows whose column `arm` is one of these. Raises ValueError in one
    line that names the file, for a column that is missing and for a value of another type; OSError where it cannot be read.
    """
    hints = get_type_hints(kind)
    with path.open(newline="", encoding="utf-8") as file:
        table = csv.reader(file)
        header = next(table, [])
        names = [name for name in kind.__dataclass_fields__ if name in hints]  # type: ignore[attr-defined]
        if absent := [name for name in names if name not in header]:
            raise ValueError(f"{path}: no column {absent[0]}, there are {', '.join(header)}; make the metrics again")
        columns = [(name, header.index(name), _reader(members(hints[name]))) for name in names]
        arm = header.index("arm") if arms is not None else None
        rows = []
        for cells in table:
            if arm is not None and arms is not None and cells[arm] not in arms:
                continue
            rows.append(kind(**{name: _value(path, name, cells[at], read) for name, at, read in columns}))
    return rows


def members(hint: Any) -> tuple[Any, ...]:
    """The types that a field may have: those of a union, or the one that it names."""
    return get_args(hint) if isinstance(hint, UnionType) else (hint,)


def _value(path: Path, name: str, cell: str, read: Callable[[str], Any]) -> Any:
    try:
        return read(cell)
    except ValueError as error:
        raise ValueError(f"{path}: {name} is {cell!r}, {error}; make the metrics again") from None


def _reader(made: Sequence[Any]) -> Callable[[str], Any]:
    first, optional = made[0], NoneType in made

    def number(cell: str) -> Any:
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise ValueError("which is no finite number")
        if first is not float and not value.is_integer():
            raise ValueError("which is no whole number")
        return first(value)

    read = number if first in (int, float, bool) else first
    return (lambda cell: None if cell == "" else read(cell)) if optional else read
