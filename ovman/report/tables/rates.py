"""The tables of success rates: the static gate and the embodied evaluation."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from ovman.analysis.rates import Interval
from ovman.report.tables.columns import (
    ALL,
    ARM_COLUMNS,
    MARK,
    RELATIONS,
    arms_frame,
    extreme_columns,
    handed_over,
    interval_columns,
    numbers,
    of_relation,
    percent,
    range_column,
    span,
    three,
    words,
)
from ovman.report.tables.table import CONTROLS, DATA, SECTION, Column, Table
from ovman.settings import Arm, Kind, Settings, Source, arms_of, of_kind
from ovman.settings.arms import other_readings

_SUFFIXES = {"rate": "", "low": "_low", "high": "_high", "least": "_min", "greatest": "_max"}


def static_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """The static gate, one row an arm that has rates. rates: rows of `Rate`.

    Arms on their own come first, then those that lack a part, then those with grounding and with positions handed over, each in
    the order of the settings, and controls last. Arms that differ from another in the reading of what is handed over stand in the
    table of readings instead. Raises ValueError for an arm that is not static.
    """
    confidence = settings.evaluation.confidence
    every = arms_of(settings.arms)
    left = other_readings(every)
    shown = (arm for arm in of_kind(every, Kind.STATIC) if arm.name not in left)
    arms = sorted(shown, key=lambda arm: (arm.control, handed_over(arm), arm.ablates is not None))
    rows = _by_arm(rates[~rates["arm"].isin(left)], arms, ALL).join(arms_frame(settings)).rename(columns={"seeds": "runs"})
    rows[SECTION] = [_section(arm) for arm in arms if arm.name in rows.index]
    caption = f"Static gate: a prediction succeeds within {settings.success.radius_m} m of the answer. {_wilson(confidence)}"
    if (rates["interval"] == Interval.POISSON_BINOMIAL).any():
        caption += f" {MARK} A stochastic pick: its expectation, and the Poisson-binomial range of one pass."
    if (rates["seeds"] > 1).any():
        caption += " Several runs: their means; runs add no episodes."
    columns = (
        *ARM_COLUMNS,
        *_relation_columns(),
        *_rate_columns(of_relation(ALL, three)),
        range_column(confidence),
        numbers("n"),
        numbers("runs"),
        words("interval", formats=DATA),
    )
    return Table(caption, columns, rows.drop(columns="spl"), wide=True)


def embodied_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """The embodied evaluation, one row an arm that has rates, in the order of the settings, controls last. rates: rows of `Rate`.

    Raises ValueError for an arm that is not embodied.
    """
    confidence = settings.evaluation.confidence
    arms = sorted(of_kind(arms_of(settings.arms), Kind.EMBODIED), key=lambda arm: arm.control)
    rows = _by_arm(rates, arms, "sr").join(arms_frame(settings)[["system"]])
    if any(arm.control and arm.name in rows.index for arm in arms):
        rows[SECTION] = [CONTROLS if arm.control else "" for arm in arms if arm.name in rows.index]
    columns = (
        words("agent"),
        *_relation_columns(),
        *_rate_columns(numbers("sr", "SR", three)),
        range_column(confidence),
        numbers("spl", "SPL", three),
        numbers("n"),
        numbers("seeds"),
    )
    caption = (
        f"Embodied evaluation: success rate (SR) at the stop and SPL, means over the seeds. {_wilson(confidence)} Seeds add no "
        "episodes and narrow no range. SPL takes the shortest path of the episode, whatever body an agent has."
    )
    return Table(caption, columns, rows.rename(columns={"system": "agent"}).drop(columns="interval"), wide=True)


def _by_arm(rates: pd.DataFrame, arms: Sequence[Arm], whole: str) -> pd.DataFrame:
    """A row an arm, in the order of `arms`: the rates of each relation (NaN where it has no episodes) and, as `whole`,
    over all; and n, seeds, spl, interval."""
    names = [arm.name for arm in arms]
    if strangers := sorted({*rates["arm"]} - {*names}):
        raise ValueError(f"{strangers[0]!r} is not an arm of this table; its arms are {', '.join(names)}")
    renamed = rates.assign(relation=rates["relation"].replace(ALL, whole))
    parts = [
        renamed.pivot(index="arm", columns="relation", values=column).reindex(columns=[*RELATIONS, whole]).add_suffix(suffix)
        for column, suffix in _SUFFIXES.items()
    ]
    over_all = rates[rates["relation"] == ALL].set_index("arm")
    marks = [MARK if interval == Interval.POISSON_BINOMIAL else "" for interval in over_all["interval"]]
    ranges = [span(low, high, mark) for low, high, mark in zip(over_all["low"], over_all["high"], marks, strict=True)]
    rows = pd.concat([*parts, over_all[["n", "seeds", "spl", "interval"]].assign(range=ranges)], axis=1)
    return rows.loc[[name for name in names if name in rows.index]]


def _relation_columns() -> list[Column]:
    return [column for relation in RELATIONS for column in _rate_columns(of_relation(relation, three))]


def _rate_columns(rate: Column) -> tuple[Column, ...]:
    return (rate, *interval_columns(rate.key), *extreme_columns(rate.key))


def _section(arm: Arm) -> str:
    if arm.control:
        return CONTROLS
    if arm.ablates is not None:
        return "a part taken away (ablation)"
    if arm.positions is Source.HANDED:
        return "oracle positions (diagnostic)"
    return "oracle grounding (diagnostic)" if arm.grounding is Source.HANDED else ""


def _wilson(confidence: float) -> str:
    return f"Ranges are Wilson {percent(confidence)} intervals."
