"""The specification of a table, and how a table is made from rows of metrics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import pandas as pd

from ovman.analysis.rows import Row
from ovman.report.tables.columns import percent
from ovman.report.tables.table import Column, Group, Table, Value
from ovman.settings import Kind, Settings

Rows = Callable[[pd.DataFrame, Settings], pd.DataFrame]


@dataclass(frozen=True)
class TableSpec:
    """A table of metrics.

    Attributes:
        caption: In words, or a function of the metrics and the settings. `{s.success.radius_m}` is a constant of the settings and
            `{confidence}` the confidence of intervals in per cent.
        columns: In their order, or a function that makes them.
        by: The columns of the metrics that rows are grouped by; each group is a row of the table. Without any, each row is one.
        rows: Filters, orders or completes the metrics before they are grouped.
        section: The heading above the rows of a group in LaTeX.
        wide: Whether LaTeX sets the table across both columns of a page.
        kind: The kind of arms of which the table has one row each, for notes on arms that were not run.
    """

    caption: str | Callable[[pd.DataFrame, Settings], str]
    columns: tuple[Column, ...] | Callable[[pd.DataFrame, Settings], tuple[Column, ...]]
    by: tuple[str, ...] = ()
    rows: Rows = lambda metrics, settings: metrics
    section: Value = lambda group: ""
    wide: bool = True
    kind: Kind | None = None


def make_table(spec: TableSpec, metrics: pd.DataFrame, settings: Settings) -> Table:
    """Make a table of rows of metrics. ValueError if the rows contradict themselves."""
    rows = spec.rows(metrics, settings)
    keys = [rows[name] for name in spec.by] or [pd.Series(range(len(rows)), index=rows.index)]
    parts = [part for _, part in rows.groupby(keys, sort=False, dropna=False)] if len(rows) else []
    groups = tuple(Group(cast(list[Row], part.to_dict("records")), settings) for part in parts)
    named = {"s": settings, "confidence": percent(settings.evaluation.confidence)}
    caption = spec.caption if isinstance(spec.caption, str) else spec.caption(metrics, settings)
    columns = spec.columns if isinstance(spec.columns, tuple) else spec.columns(metrics, settings)
    return Table(
        caption.format(**named),
        tuple(replace(column, title=column.title.format(**named)) for column in columns),
        groups,
        tuple(str(spec.section(group)) for group in groups),
        spec.wide,
    )


def read_metrics(path: Path) -> pd.DataFrame:
    """Read a csv file of metrics: whole numbers, other numbers and words by their looks; empty is NaN or NA, in words ""."""
    return type_metrics(pd.read_csv(path, dtype=str, keep_default_na=False, encoding="utf-8"))


def type_metrics(text: pd.DataFrame) -> pd.DataFrame:
    """Type the columns of metrics that were read as text."""
    return pd.DataFrame({name: _typed(text[name]) for name in text.columns})


def _typed(column: pd.Series[str]) -> pd.Series[Any]:
    there = column[column != ""]
    if there.str.fullmatch(r"-?\d+").all():
        return pd.to_numeric(column.where(column != "", None)).astype("int64" if len(there) == len(column) else "Int64")
    numbers = pd.to_numeric(there, errors="coerce")
    return column if numbers.isna().any() else numbers.astype("float64").reindex(column.index)
