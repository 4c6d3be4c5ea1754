"""Rows of metrics, frozen dataclasses, as typed data frames and as csv files; a column a field."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import numpy as np
import pandas as pd

from ovman.analysis.rows import members, read_rows

__all__ = ["csv_text", "dtypes", "frame_of", "read", "read_rows", "rows_of", "typed", "write"]

P_VALUES = ("p", "p_holm")
"""Columns that are written with six significant digits, as six decimals would round small values to 0."""

RowType = TypeVar("RowType")


def frame_of(kind: type[RowType], rows: Iterable[RowType]) -> pd.DataFrame:
    """A data frame with a typed column for each field of the dataclass `kind`. None is NaN, or NA in a column of counts."""
    every = list(rows)
    return pd.DataFrame(
        {name: pd.Series([_plain(getattr(row, name)) for row in every], dtype=dtype) for name, dtype in dtypes(kind).items()}
    )


def csv_text(kind: type[RowType], rows: Iterable[RowType]) -> str:
    """RFC 4180 with a line feed at each end of line: six decimals for floats, 1 and 0 for truth values, nothing for None."""
    frame = frame_of(kind, rows)
    for name in frame.columns.intersection(list(P_VALUES)):
        frame[name] = frame[name].map("{:.6g}".format, na_action="ignore").astype(str).where(frame[name].notna(), "")
    return frame.to_csv(index=False, lineterminator="\n", float_format=_decimals)


def write(path: Path, kind: type[RowType], rows: Iterable[RowType]) -> None:
    """Write `csv_text` of the rows to `path`."""
    path.write_text(csv_text(kind, rows), encoding="utf-8", newline="\n")


def read(path: Path, kind: type[RowType]) -> pd.DataFrame:
    """The rows of a file of metrics as `frame_of` types them; empty text is "" in a column of words and NaN or NA in others.

    Raises ValueError in one line that names the file, for a column that is missing and for a value of another type.
    """
    try:
        return typed(pd.read_csv(path, dtype=str, keep_default_na=False, encoding="utf-8"), kind)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def typed(text: pd.DataFrame, kind: type[RowType]) -> pd.DataFrame:
    """The rows of a frame whose cells are all text. Raises ValueError as `read`."""
    wanted = dtypes(kind)
    if absent := [name for name in wanted if name not in text.columns]:
        raise ValueError(f"no column {absent[0]}, there are {', '.join(text.columns)}; make the metrics again")
    columns = {}
    for name, dtype in wanted.items():
        column = text[name]
        if dtype != "str":
            numbers = pd.to_numeric(column.where(column != "", None), errors="coerce").astype("float64")
            if (wrong := column[(column != "") & ~np.isfinite(numbers)]).size:
                raise ValueError(f"{name} is {wrong.iloc[0]!r}, which is no finite number; make the metrics again")
            if dtype == "int64" and numbers.isna().any():
                raise ValueError(f"{name} is empty in a row; make the metrics again")
            if dtype != "float64" and (wrong := column[numbers.notna() & (numbers % 1 != 0)]).size:
                raise ValueError(f"{name} is {wrong.iloc[0]!r}, which is no whole number; make the metrics again")
            column = pd.Series(numbers, dtype=dtype)
        columns[name] = column
    return pd.DataFrame(columns)


def rows_of(kind: type[RowType], frame: pd.DataFrame) -> list[RowType]:
    """The rows of a frame as `kind`, the inverse of `frame_of`."""
    hints, names = get_type_hints(kind), list(dtypes(kind))

    def value(name: str, cell: Any) -> Any:
        made = members(hints[name])
        if pd.isna(cell) or (cell == "" and type(None) in made):
            return None
        return made[0](cell)

    return [kind(**{name: value(name, cell) for name, cell in zip(names, row, strict=True)}) for row in _tuples(frame[names])]


def dtypes(kind: type) -> dict[str, str]:
    """The type of a column for each field of a dataclass: float64; int64, or Int64 where None is possible; else str."""
    hints = get_type_hints(kind)
    return {field.name: _dtype(members(hints[field.name])) for field in fields(kind)}


def _dtype(made: Sequence[Any]) -> str:
    if float in made:
        return "float64"
    if set(made) <= {int, bool, type(None)}:
        return "Int64" if {bool, type(None)} & set(made) else "int64"
    return "str"


def _plain(value: Any) -> Any:
    return value if value is None or isinstance(value, int | float) else str(value)


def _tuples(frame: pd.DataFrame) -> Iterable[tuple[Any, ...]]:
    return frame.itertuples(index=False, name=None)


def _decimals(value: object) -> str:
    # Python rounds exactly, NumPy does not. Adding zero drops the sign that rounding may leave on a zero.
    return f"{round(float(str(value)), 6) + 0.0:.6f}"
