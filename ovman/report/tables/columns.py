"""How numbers stand in tables, and the columns that several tables share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import pandas as pd

from ovman.records.task import Relation
from ovman.report.tables.table import CSV_AND_MARKDOWN, DATA, EVERYWHERE, PAGE, Column, Format, escaped
from ovman.settings import Arm, Settings, Source, arms_of

ALL = "all"
RELATIONS = tuple(relation.value for relation in Relation)
_NAMES = re.compile(rf"\b({'|'.join((*RELATIONS, ALL)).upper()})\b")
MARK = "†"
"""Stands beside an expectation over a stochastic pick."""


def three(value: float) -> str:
    """Three decimals."""
    return f"{value:.3f}"


def signed(value: float) -> str:
    """Three decimals and a sign."""
    return f"{value:+.3f}"


def six_digits(value: float) -> str:
    """Six significant digits: a p-value, however small, as the metrics write it."""
    return f"{value:.6g}"


def p_value(value: float) -> str:
    """Three decimals, or two digits and a power of ten below a thousandth."""
    if value == 0.0 or value >= 0.001:
        return f"{value:.3f}" if value else "0"
    mantissa, power = f"{value:.1e}".split("e")
    return f"{mantissa}e{int(power)}"


def power_of_ten(text: str) -> str:
    r"""LaTeX of a p-value of `p_value`: "4.4e-41" as $4.4\times10^{-41}$."""
    mantissa, _, power = text.partition("e")
    return rf"${mantissa}\times10^{{{power}}}$" if power else escaped(text)


def percent(share: float) -> str:
    """A share in per cent."""
    return f"{100 * share:.6g} %"


def span(low: float, high: float, mark: str = "") -> str:
    """From low to high, three decimals each; empty where there is no low."""
    return "" if pd.isna(low) else f"{three(low)}–{three(high)}{mark}"


def count(value: float, expected: bool = False) -> str:
    """A count without decimals; the expectation of one with one."""
    return f"{value:.{int(expected)}f}"


def small_capitals(text: str) -> str:
    r"""LaTeX of a text whose names of relations, in capitals, are set in \textsc."""
    return _NAMES.sub(lambda name: rf"\textsc{{{name.group().lower()}}}", escaped(text))


def words(
    key: str, title: str | None = None, formats: frozenset[Format] = EVERYWHERE, tex: Callable[[str], str] = escaped
) -> Column:
    """A column of words, aligned to the left."""
    return Column(key, key if title is None else title, tex=tex, formats=formats)


def numbers(
    key: str, title: str | None = None, data: Callable[[Any], str] = str, formats: frozenset[Format] = EVERYWHERE
) -> Column:
    """A column of numbers, aligned to the right."""
    return Column(key, key if title is None else title, data, numeric=True, formats=formats)


def p_values(key: str, title: str) -> Column:
    """A column of p-values: six digits in the csv, `p_value` on a page."""
    return Column(key, title, six_digits, p_value, power_of_ten, numeric=True)


def relation_column() -> Column:
    """A column that names a relation, or all."""
    return Column("relation", "relation", str.upper, tex=small_capitals)


def of_relation(relation: str, data: Callable[[Any], str] = str) -> Column:
    """A column of numbers under the name of a relation, or all, in small capitals on pages."""
    return Column(relation, relation.upper(), data, title_tex=small_capitals(relation.upper()), numeric=True)


def range_column(confidence: float, key: str = "range") -> Column:
    """A column of intervals as pages show them, from low to high."""
    return Column(key, percent(confidence), formats=PAGE)


def interval_columns(key: str) -> tuple[Column, Column]:
    """The two ends of an interval, in the csv."""
    return numbers(f"{key}_low", f"{key} low", three, DATA), numbers(f"{key}_high", f"{key} high", three, DATA)


def extreme_columns(key: str) -> tuple[Column, Column]:
    """The least and the greatest of the seeds or runs, in the csv."""
    return numbers(f"{key}_min", f"{key} least", three, DATA), numbers(f"{key}_max", f"{key} greatest", three, DATA)


def spread_columns(key: str, title: str) -> tuple[Column, ...]:
    """A figure's mean over the seeds, least and greatest; pages have them in one column."""
    return (
        numbers(key, title, three, DATA),
        numbers(f"{key}_min", f"{title} least", three, DATA),
        numbers(f"{key}_max", f"{title} greatest", three, DATA),
        Column(f"{key}_page", title, formats=PAGE),
    )


def spread(values: pd.Series[float], key: str) -> dict[str, object]:
    """The values of `spread_columns`; values: one a seed, absent ones are passed over."""
    there = values.dropna()
    if there.empty:
        return {}
    mean, least, greatest = exact_mean(there), there.min(), there.max()
    page = f"{three(mean)} ({three(least)}–{three(greatest)})" if len(there) > 1 else three(mean)
    return {key: mean, f"{key}_min": least, f"{key}_max": greatest, f"{key}_page": page}


ARM_COLUMNS = (
    words("system"),
    words("memory"),
    words("grounding", formats=CSV_AND_MARKDOWN),
    words("positions", formats=CSV_AND_MARKDOWN),
)
"""What tables say of an arm."""


def arms_frame(settings: Settings) -> pd.DataFrame:
    """What tables say of each arm, by its name, in the order of the settings."""
    given = {Source.OWN: "own", Source.HANDED: "oracle"}
    rows = [[arm.system, arm.memory, given[arm.grounding], given[arm.positions]] for arm in arms_of(settings.arms)]
    return pd.DataFrame(rows, columns=[column.key for column in ARM_COLUMNS], index=pd.Index(settings.arms, name="arm"))


def handed_over(arm: Arm) -> int:
    """How much an arm is handed over: 0 nothing, 1 grounding, 2 or more positions."""
    return (arm.grounding is Source.HANDED) + 2 * (arm.positions is Source.HANDED)


def exact_mean(values: pd.Series[float]) -> float:
    """The mean of numbers, of their exact sum."""
    return math.fsum(values) / len(values)
