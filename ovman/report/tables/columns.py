"""How numbers are written in tables, how a cell follows from rows of metrics, and the columns that several tables share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from ovman.analysis.rates import Interval
from ovman.records.task import Relation
from ovman.report.tables.table import (
    ALL,
    CSV_AND_MARKDOWN,
    DATA,
    EVERYWHERE,
    PAGE,
    Column,
    Format,
    Group,
    Value,
    escape_latex,
)
from ovman.settings import Source

RELATIONS = tuple(relation.value for relation in Relation)
_NAMES = re.compile(rf"\b({'|'.join((*RELATIONS, ALL)).upper()})\b")
MARK = "†"
"""Marks an expectation over a stochastic pick."""

# --- how values are written -----------------------------------------------------------------------


def three(value: float | str) -> str:
    """Write three decimals; words stay words."""
    return value if isinstance(value, str) else f"{value:.3f}"


def signed(value: float) -> str:
    """Write three decimals and a sign."""
    return f"{value:+.3f}"


def six_digits(value: float) -> str:
    """Write a p-value with six significant digits, as the metrics do."""
    return f"{value:.6g}"


def p_value(value: float) -> str:
    """Write three decimals, or two digits and a power of ten below a thousandth."""
    if value == 0.0 or value >= 0.001:
        return f"{value:.3f}" if value else "0"
    mantissa, power = f"{value:.1e}".split("e")
    return f"{mantissa}e{int(power)}"


def power_of_ten(text: str) -> str:
    r"""Write a p-value of `p_value` in LaTeX: "4.4e-41" as $4.4\times10^{-41}$."""
    mantissa, _, power = text.partition("e")
    return rf"${mantissa}\times10^{{{power}}}$" if power else escape_latex(text)


def percent(share: float) -> str:
    """Write a share in per cent."""
    return f"{100 * share:.6g} %"


def span(low: float | None, high: float | None, mark: str = "") -> str:
    """Write a range, three decimals each; nothing without a low end."""
    return "" if low is None or high is None else f"{three(low)}–{three(high)}{mark}"


def count(value: float, expected: bool = False) -> str:
    """Write a count without decimals, the expectation of one with one decimal."""
    return f"{value:.{int(expected)}f}"


def one_decimal(value: float) -> str:
    """Write one decimal."""
    return f"{value:.1f}"


def small_capitals(text: str) -> str:
    r"""Write a text in LaTeX whose names of relations, in capitals, are set in \textsc."""
    return _NAMES.sub(lambda name: rf"\textsc{{{name.group().lower()}}}", escape_latex(text))


# --- how a cell follows from the rows of a group --------------------------------------------------


def get(name: str) -> Value:
    """Take `Group.get` of a column."""
    return lambda group: group.get(name)


def mean(name: str) -> Value:
    """Take the mean of the values that are there, by their exact sum."""
    return lambda group: exact_mean(group.values(name))


def least(name: str) -> Value:
    """Take the least value."""
    return lambda group: min(group.values(name), default=None)


def most(name: str) -> Value:
    """Take the greatest value."""
    return lambda group: max(group.values(name), default=None)


def joined(name: str, write: Callable[[Any], str] = str) -> Value:
    """List the values that are there, separated by commas."""
    return lambda group: ", ".join(map(write, group.values(name)))


def count_rows(group: Group) -> int:
    """Count the rows of metrics."""
    return len(group.rows)


def of_arm(name: str) -> Value:
    """Take a field of the entry of the group's arm in the settings."""
    return lambda group: getattr(group.settings.arms[group.get("arm")], name)


def exact_mean(values: Sequence[float]) -> float | None:
    """Return the mean of numbers by their exact sum, None without any."""
    return math.fsum(values) / len(values) if values else None


def _mean_and_extremes(name: str) -> Value:
    """Write the mean, least and greatest value in one cell, the mean alone if there is one value."""

    def write(group: Group) -> str:
        values = group.values(name)
        if not values:
            return ""
        text = three(mean(name)(group))
        return text if len(values) == 1 else f"{text} ({span(min(values), max(values))})"

    return write


def interval_text(group: Group) -> str:
    """Write the interval from low to high, with a mark if it is that of a stochastic pick."""
    return span(group.get("low"), group.get("high"), MARK if group.get("interval") == Interval.POISSON_BINOMIAL else "")


# --- columns --------------------------------------------------------------------------------------


def words(
    key: str,
    title: str | None = None,
    value: Value | None = None,
    formats: frozenset[Format] = EVERYWHERE,
    tex: Callable[[str], str] = escape_latex,
) -> Column:
    """Make a column of words, aligned to the left."""
    return Column(key, key if title is None else title, value, tex=tex, formats=formats)


def numbers(
    key: str,
    title: str | None = None,
    data: Callable[[Any], str] = str,
    value: Value | None = None,
    formats: frozenset[Format] = EVERYWHERE,
) -> Column:
    """Make a column of numbers, aligned to the right."""
    return Column(key, key if title is None else title, value, data, numeric=True, formats=formats)


def data_words(*keys: str) -> tuple[Column, ...]:
    """Make columns of words that only the csv has."""
    return tuple(words(key, formats=DATA) for key in keys)


def counts(*keys: str) -> tuple[Column, ...]:
    """Make columns of numbers that are written as they are, under their own keys."""
    return tuple(numbers(key) for key in keys)


def p_values(key: str = "p", title: str = "p", value: Value | None = None) -> Column:
    """Make a column of p-values: six digits in the csv, `p_value` on a page."""
    return Column(key, title, value, six_digits, p_value, power_of_ten, numeric=True)


def relation_column(key: str = "relation", title: str = "relation") -> Column:
    """Make a column that names a relation, or all."""
    return Column(key, title, data=str.upper, tex=small_capitals)


def of_relation(relation: str, name: str = "rate", data: Callable[[Any], str] = three, **kept: Any) -> Column:
    """Make the column of a value of a relation, or of all; its title is in small capitals. kept: other fields of the column."""
    column = Column(
        relation, relation.upper(), _in(relation, name), data, title_tex=small_capitals(relation.upper()), numeric=True
    )
    return replace(column, **kept)


def rates_by_relation(*relations: str, ends: Sequence[str] = ()) -> tuple[Column, ...]:
    """Make the columns of the rates of relations, of all if none is named, and in the csv those of INTERVAL and EXTREMES."""
    return tuple(
        column for relation in relations or (*RELATIONS, ALL) for column in (of_relation(relation), *end_columns(relation, ends))
    )


def end_columns(relation: str, ends: Sequence[str], key: str = "") -> tuple[Column, ...]:
    """Make the columns of INTERVAL and EXTREMES of a relation, in the csv. key: their name, the relation if not given."""
    return tuple(numbers(f"{key or relation}_{_ENDS[end]}", "", three, _in(relation, end), DATA) for end in ends)


INTERVAL, EXTREMES = ("low", "high"), ("least", "greatest")
_ENDS = {"low": "low", "high": "high", "least": "min", "greatest": "max"}


def _in(relation: str, name: str) -> Value:
    return lambda group: group.where(relation=relation).get(name)


def spread_columns(key: str, title: str, name: str | None = None) -> tuple[Column, ...]:
    """Make the columns of a mean over the seeds, least and greatest; pages have them in one column."""
    name = name or key
    return (
        numbers(key, title, three, mean(name), DATA),
        numbers(f"{key}_min", f"{title} least", three, least(name), DATA),
        numbers(f"{key}_max", f"{title} greatest", three, most(name), DATA),
        words(f"{key}_page", title, _mean_and_extremes(name), PAGE),
    )


def _handed(name: str) -> Value:
    return lambda group: {Source.OWN: "own", Source.HANDED: "oracle"}[of_arm(name)(group)]


RANGE = words("range", "{confidence}", interval_text, PAGE)
"""The interval as pages show it, under the confidence in per cent."""
ARM_COLUMNS = (
    words("system", value=of_arm("system")),
    words("memory", value=of_arm("memory")),
    words("grounding", value=_handed("grounding"), formats=CSV_AND_MARKDOWN),
    words("positions", value=_handed("positions"), formats=CSV_AND_MARKDOWN),
)
"""The description of an arm."""
