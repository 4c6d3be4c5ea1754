"""Read and write rows of metrics as csv files, without pandas: `ovman score` reads released rates and starts quickly."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from types import NoneType
from typing import Any, TypeVar, get_args, get_type_hints

from pydantic import TypeAdapter, ValidationError

Row = dict[str, Any]
RowType = TypeVar("RowType")
P_VALUES = ("p", "p_holm", "p_scenes")
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
    optional = {name for name, hint in hints.items() if NoneType in get_args(hint)}
    with path.open(newline="", encoding="utf-8") as file:
        rows = [
            {name: None if cell == "" and name in optional else cell for name, cell in row.items() if name in hints}
            for row in csv.DictReader(file)
            if arms is None or row["arm"] in arms
        ]
    try:
        return TypeAdapter(list[kind]).validate_python(rows)  # type: ignore[valid-type]
    except ValidationError as error:
        wrong = error.errors()[0]
        number, name = wrong["loc"][0], wrong["loc"][-1]
        raise ValueError(f"{path}: {name} in row {int(number) + 1}: {wrong['msg']}; make the metrics again") from None


def _cell(name: str, value: Any) -> str:
    if value is None or value != value:
        return ""
    if isinstance(value, str):
        return value
    if not isinstance(value, float):
        return str(int(value))
    # Python's round is exact, NumPy's is not. Adding zero removes the sign of a rounded zero.
    return f"{value:.6g}" if name in P_VALUES else f"{round(float(value), 6) + 0.0:.6f}"
