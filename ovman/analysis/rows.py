"""Read and write rows of metrics as csv files, without pandas: `ovman score` reads released rates and starts quickly."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, TypeVar, get_args, get_type_hints

Row = dict[str, Any]
RowType = TypeVar("RowType")
P_VALUES = ("p", "p_holm")
"""Columns with six significant digits: six decimals would round small values to 0."""


def csv_text(columns: str, rows: Iterable[Mapping[str, Any] | object]) -> str:
    """Format columns of mappings or dataclasses as csv. columns: their names, separated by blanks.

    Floats have six decimals, truth values are 1 and 0, None is empty.
    """
    names, text = columns.split(), io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    for row in rows:
        values = [row[name] if isinstance(row, Mapping) else getattr(row, name) for name in names]
        writer.writerow([_cell(name, value) for name, value in zip(names, values, strict=True)])
    return text.getvalue()


def write_csv(path: Path, columns: str, rows: Iterable[Mapping[str, Any] | object]) -> None:
    """Write `csv_text` to a file."""
    path.write_text(csv_text(columns, rows), encoding="utf-8", newline="\n")


def read_rows(path: Path, kind: type[RowType], arms: Collection[str] | None = None) -> list[RowType]:
    """Read the rows of a csv file as dataclasses; a field with a default may lack its column.

    Args:
        path: A file of metrics.
        kind: The dataclass. Empty text is None where a field may be None.
        arms: Read only the rows whose column `arm` is one of these.

    Raises:
        ValueError: A column is missing or a value has another type; one line with the file.
    """
    hints = get_type_hints(kind)
    with path.open(newline="", encoding="utf-8") as file:
        table = csv.DictReader(file)
        header = table.fieldnames or []
        for field in fields(kind):  # type: ignore[arg-type]
            if field.name not in header and field.default is MISSING:
                raise ValueError(f"{path}: the column {field.name} is missing; make the metrics again")
        readers = {name: _reader(hints[name]) for name in header if name in hints}
        return [
            kind(**{name: _value(path, name, row[name], read) for name, read in readers.items()})
            for row in table
            if arms is None or row["arm"] in arms
        ]


def _cell(name: str, value: Any) -> str:
    if value is None or value != value:
        return ""
    if isinstance(value, str):
        return value
    if not isinstance(value, float):
        return str(int(value))
    # Python's round is exact, NumPy's is not. Adding zero removes the sign of a rounded zero.
    return f"{value:.6g}" if name in P_VALUES else f"{round(float(value), 6) + 0.0:.6f}"


def _value(path: Path, name: str, cell: str, read: Callable[[str], Any]) -> Any:
    try:
        return read(cell)
    except ValueError as error:
        raise ValueError(f"{path}: {name} is {cell!r}, {error}; make the metrics again") from None


def _reader(hint: Any) -> Callable[[str], Any]:
    members = get_args(hint) if isinstance(hint, UnionType) else (hint,)
    first = members[0]

    def number(cell: str) -> Any:
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise ValueError("which is not a finite number")
        if first is not float and not value.is_integer():
            raise ValueError("which is not a whole number")
        return first(value)

    read = number if first in (int, float, bool) else first
    return (lambda cell: None if cell == "" else read(cell)) if NoneType in members else read
