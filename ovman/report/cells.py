"""How numbers of the metrics stand in the cells of a table, and the columns that several tables share."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from ovman.report.table import DATA, PAGE, Column, Text, Words
from ovman.task import Relation

# A row of a file of metrics, as the csv reader gives it.
Record = Mapping[str, str]

RELATIONS = tuple(relation.value for relation in Relation)
MARK = "†"
"""Stands beside an expectation over a stochastic pick."""


def grouped(rows: Iterable[Record], *columns: str) -> dict[tuple[str, ...], list[Record]]:
    """Rows by their values in these columns, groups and rows in the order in which they come."""
    groups: dict[tuple[str, ...], list[Record]] = {}
    for row in rows:
        groups.setdefault(tuple(row[column] for column in columns), []).append(row)
    return groups


def number(text: str) -> str:
    """Three decimals."""
    return f"{float(text):.3f}"


def signed(text: str) -> str:
    """Three decimals and a sign; nothing stays nothing."""
    return f"{float(text):+.3f}" if text else ""


def count(text: str, expected: bool = False) -> str:
    """A count without decimals, an expectation of one with one."""
    return f"{float(text):.{int(expected)}f}"


def p_value(text: str) -> Words:
    """Three decimals, or two digits and a power of ten below a thousandth; nothing stays nothing."""
    if not text:
        return ""
    value = float(text)
    if value == 0.0 or value >= 0.001:
        return f"{value:.3f}" if value else "0"
    mantissa, power = f"{value:.1e}".split("e")
    return Text(f"{mantissa}e{int(power)}", rf"${mantissa}\times10^{{{int(power)}}}$")


def percent(share: float) -> str:
    """A share in per cent."""
    return f"{100 * share:.6g} %"


def span(low: str, high: str) -> str:
    """From low to high, three decimals each; nothing stays nothing."""
    return f"{number(low)}–{number(high)}" if low else ""


def small_capitals(relation: str) -> Text:
    """The name of a relation, or "all", as pages write it."""
    return Text(relation.upper(), rf"\textsc{{{relation}}}")


def relation_columns() -> tuple[Column, ...]:
    """A numeric column for each relation and one for all."""
    return tuple(Column(relation, small_capitals(relation), numeric=True) for relation in (*RELATIONS, "all"))


def spread_columns(key: str, title: str) -> tuple[Column, ...]:
    """A figure's mean over the seeds, least and greatest; pages have them in one column."""
    return (
        Column(key, title, numeric=True, formats=DATA),
        Column(f"{key}_min", f"{title} least", numeric=True, formats=DATA),
        Column(f"{key}_max", f"{title} greatest", numeric=True, formats=DATA),
        Column(f"{key}_page", title, formats=PAGE),
    )


def spread_cells(key: str, values: Sequence[float]) -> dict[str, str]:
    """The cells of ``spread_columns``; values: one a seed, at least one."""
    mean, least, greatest = (number(str(v)) for v in (math.fsum(values) / len(values), min(values), max(values)))
    return {key: mean, f"{key}_min": least, f"{key}_max": greatest, f"{key}_page": f"{mean} ({least}–{greatest})"}
