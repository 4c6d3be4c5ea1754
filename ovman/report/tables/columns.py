"""How numbers are written in tables, how a cell follows from rows of metrics, and the columns that several tables share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from ovman.analysis.rates import Interval
from ovman.records.task import Relation
from ovman.report.tables.table import ALL, CSV_AND_MARKDOWN, DATA, EVERYWHERE, PAGE, Column, Format, Group, Value, escape_latex
from ovman.settings import Kind, Source

RELATIONS = tuple(relation.value for relation in Relation)
_NAMES = re.compile(rf"\b({'|'.join((*RELATIONS, ALL)).upper()})\b")
MARK = "†"
"""Marks an expectation over a stochastic pick."""
JUDGED = {Kind.STATIC: "static gate", Kind.EMBODIED: "driving"}

# --- how values are written -----------------------------------------------------------------------

one_decimal, signed = "{:.1f}".format, "{:+.3f}".format


def three(value: float | str) -> str:
    """Write three decimals; words stay words."""
    return value if isinstance(value, str) else f"{value:.3f}"


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


def span(low: float | None, high: float | None, mark: str = "") -> str:
    """Write a range, three decimals each; nothing without a low end."""
    return "" if low is None or high is None else f"{three(low)}–{three(high)}{mark}"


def count(value: float, expected: bool = False) -> str:
    """Write a count without decimals, the expectation of one with one decimal."""
    return f"{value:.{int(expected)}f}"


def small_capitals(text: str) -> str:
    r"""Write a text in LaTeX whose names of relations, in capitals, are set in \textsc."""
    return _NAMES.sub(lambda name: rf"\textsc{{{name.group().lower()}}}", escape_latex(text))


# --- how a cell follows from the rows of a group --------------------------------------------------


def get(name: str, **where: str) -> Value:
    """Take `Group.get` of a column, of the rows with these values."""
    return lambda group: group.where(**where).get(name)


def mean(name: str, **where: str) -> Value:
    """Take the mean of the values of the rows with these values, by their exact sum."""
    return lambda group: math.fsum(values) / len(values) if (values := group.where(**where).values(name)) else None


def least(name: str, **where: str) -> Value:
    """Take the least value of the rows with these values."""
    return lambda group: min(group.where(**where).values(name), default=None)


def most(name: str, **where: str) -> Value:
    """Take the greatest value of the rows with these values."""
    return lambda group: max(group.where(**where).values(name), default=None)


def joined(name: str, write: Callable[[Any], str] = str, **where: str) -> Value:
    """List the values of the rows with these values, separated by commas."""
    return lambda group: ", ".join(map(write, group.where(**where).values(name)))


def count_rows(group: Group) -> int:
    """Count the rows of metrics."""
    return len(group.rows)


def of_arm(name: str) -> Value:
    """Take a field of the entry of the group's arm in the settings."""
    return lambda group: getattr(group.settings.arms[group.get("arm")], name)


def judged(group: Group) -> str:
    """Say how the arm of a group is judged."""
    return JUDGED[group.get("kind")]


def interval(**where: str) -> Value:
    """Write the interval from low to high of the rows with these values, with a mark if it is that of a stochastic pick."""

    def write(group: Group) -> str:
        of = group.where(**where)
        return span(of.get("low"), of.get("high"), MARK if of.get("interval") == Interval.POISSON_BINOMIAL else "")

    return write


# --- columns --------------------------------------------------------------------------------------


def words(
    key: str,
    title: str | None = None,
    value: Value | None = None,
    formats: tuple[Format, ...] = EVERYWHERE,
    tex: Callable[[str], str] = escape_latex,
) -> Column:
    """Make a column of words, aligned to the left."""
    return Column(key, key if title is None else title, value, tex=tex, formats=formats)


def numbers(
    key: str,
    title: str | None = None,
    data: Callable[[Any], str] = str,
    value: Value | None = None,
    formats: tuple[Format, ...] = EVERYWHERE,
) -> Column:
    """Make a column of numbers, aligned to the right."""
    return Column(key, key if title is None else title, value, data, numeric=True, formats=formats)


def labels(*keys: str, formats: tuple[Format, ...] = EVERYWHERE, **titles: str) -> tuple[Column, ...]:
    """Make columns of words, first those under their own keys, then those with titles."""
    return tuple(words(key, title, formats=formats) for key, title in [*zip(keys, keys, strict=True), *titles.items()])


def counts(*keys: str, data: Callable[[Any], str] = str, **titles: str) -> tuple[Column, ...]:
    """Make columns of numbers, first those under their own keys, then those with titles. data: how they are written."""
    return tuple(numbers(key, title, data) for key, title in [*zip(keys, keys, strict=True), *titles.items()])


def rates(*keys: str, **titles: str) -> tuple[Column, ...]:
    """Make columns of numbers with three decimals, first those under their own keys, then those with titles."""
    return counts(*keys, data=three, **titles)


def p_values(key: str = "p", title: str = "p", value: Value | None = None) -> Column:
    """Make a column of p-values: six digits in the csv, `p_value` on a page."""
    return Column(key, title, value, "{:.6g}".format, p_value, power_of_ten, numeric=True)


def relation_column(key: str = "relation", title: str = "relation") -> Column:
    """Make a column that names a relation, or all."""
    return Column(key, title, data=str.upper, tex=small_capitals)


def of_relation(relation: str, name: str = "rate", data: Callable[[Any], str] = three, **kept: Any) -> Column:
    """Make the column of a value of a relation, or of all; its title is in small capitals. kept: other fields of the column."""
    title, value = relation.upper(), get(name, relation=relation)
    return replace(Column(relation, title, value, data, title_tex=small_capitals(title), numeric=True), **kept)


def rates_by_relation(*relations: str, ends: Sequence[str] = ()) -> tuple[Column, ...]:
    """Make the columns of the rates of relations, of all if none is named, and in the csv those of INTERVAL and EXTREMES."""
    return tuple(
        column for relation in relations or (*RELATIONS, ALL) for column in (of_relation(relation), *end_columns(relation, ends))
    )


def end_columns(relation: str, ends: Sequence[str], key: str = "") -> tuple[Column, ...]:
    """Make the columns of INTERVAL and EXTREMES of a relation, in the csv. key: their name, the relation if not given."""
    return tuple(numbers(f"{key or relation}_{_ENDS[end]}", "", three, get(end, relation=relation), DATA) for end in ends)


INTERVAL, EXTREMES = ("low", "high"), ("least", "greatest")
_ENDS = {"low": "low", "high": "high", "least": "min", "greatest": "max"}


def spread_columns(key: str, title: str, name: str | None = None) -> tuple[Column, ...]:
    """Make the columns of a mean over the seeds, least and greatest; pages have them in one column."""
    name = name or key

    def mean_and_extremes(group: Group) -> str:
        values = group.values(name)
        extremes = f" ({span(min(values), max(values))})" if len(values) > 1 else ""
        return three(mean(name)(group)) + extremes if values else ""

    return (
        numbers(key, title, three, mean(name), DATA),
        numbers(f"{key}_min", f"{title} least", three, least(name), DATA),
        numbers(f"{key}_max", f"{title} greatest", three, most(name), DATA),
        words(f"{key}_page", title, mean_and_extremes, PAGE),
    )


def _handed(name: str) -> Value:
    return lambda group: {Source.OWN: "own", Source.HANDED: "oracle"}[of_arm(name)(group)]


RANGE = words("range", "{confidence}", interval(), PAGE)
"""The interval as pages show it, under the confidence in per cent."""


def count_effective(group: Group) -> int | None:
    """Return the effective number of episodes: n over the design effect, at most n."""
    effect = group.get("design_effect")
    return None if effect is None else round(group.get("n") / max(1.0, effect))


BY_SCENE = (
    *(numbers(end, data=three, formats=DATA) for end in ("scene_low", "scene_high", "design_effect")),
    words("scene_range", "by scene", lambda group: span(group.get("scene_low"), group.get("scene_high")), PAGE),
    numbers("n_effective", "effective n", value=count_effective, formats=PAGE),
)
"""The interval when whole scenes are resampled, and what the episodes are worth if scenes, not episodes, are independent."""
SCENE_CAPTION = " By scene: the interval when whole scenes are resampled; effective n: episodes over the design effect."
ARM_COLUMNS = (
    words("system", value=of_arm("system")),
    words("memory", value=of_arm("memory")),
    words("grounding", value=_handed("grounding"), formats=CSV_AND_MARKDOWN),
    words("positions", value=_handed("positions"), formats=CSV_AND_MARKDOWN),
)
"""The description of an arm."""
