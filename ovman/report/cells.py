"""How numbers of the metrics stand in the cells of a table, and the columns that several tables share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ovman.report.table import Column, Text, Words
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
