"""Rows of metrics, dataclasses, as the csv files that they are in."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

# Six decimals would make nothing of them.
P_VALUES = frozenset({"p", "p_holm"})


def csv_of(kind: type, rows: Iterable[Any]) -> str:
    """Rows of the dataclass `kind`, a column a field, as ``csv_text`` writes them; p-values with six digits, however small."""
    return csv_text([field.name for field in fields(kind)], map(_cells, rows))


def csv_text(header: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """RFC 4180 with a line feed at each end of line: six decimals for floats, 1 and 0 for truth values, nothing for None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow([_cell(row[key]) for key in header])
    return text.getvalue()


def _cells(row: Any) -> dict[str, Any]:
    cells = asdict(row)
    return cells | {key: f"{cells[key]:.6g}" for key in P_VALUES & cells.keys() if cells[key] is not None}


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    # Adding zero drops the sign that rounding may leave on a zero.
    return f"{round(value, 6) + 0.0:.6f}" if isinstance(value, float) else str(value)
