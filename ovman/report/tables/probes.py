"""The tables of the two-visit agent asked again: under other association gates, and with one past relation for the other."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import (
    interval_columns,
    numbers,
    range_column,
    relation_column,
    small_capitals,
    span,
    three,
    words,
)
from ovman.report.tables.table import Column, Table
from ovman.settings import Settings


def gate_sweep_table(gates: pd.DataFrame, settings: Settings) -> Table:
    """Static success by the association gate. gates: rows of `GateRate`."""
    arm, delta_min_m = settings.arms[settings.comparisons.memory.arm], settings.candidates.delta_min_m
    rows = pd.DataFrame(
        {
            "gate_m": gates["gate_m"],
            "in_force": gates["in_force"].map({1: "yes", 0: ""}),
            "n": gates["n"],
            "success": gates["success"],
            "success_low": gates["low"],
            "success_high": gates["high"],
            "range": [span(low, high) for low, high in zip(gates["low"], gates["high"], strict=True)],
        }
    )
    columns = (
        numbers("gate_m", "gate, m", "{:g}".format),
        words("in_force", "in force"),
        numbers("n"),
        numbers("success", data=three),
        *interval_columns("success"),
        range_column(settings.evaluation.confidence),
    )
    caption = f"Static success of {arm.system}, {arm.memory}, by the association gate."
    if len(gates):
        caption += (
            f" It spans {gates['success'].max() - gates['success'].min():.3f}. "
            f"The smallest displacement that is asked about is {delta_min_m} m."
        )
    return Table(caption, columns, rows)


def read_as_table(relations: pd.DataFrame, settings: Settings) -> Table:
    """What is left of the answers where one past relation is read as the other. relations: rows of `ReadAs`."""
    columns = (
        relation_column(),
        Column("read_as", "read as", str.upper, tex=small_capitals),
        numbers("n"),
        numbers("answered"),
        numbers("same", "same answer"),
        numbers("only_read_as", "answered only as read"),
        numbers("successes"),
        numbers("successes_read_as", "successes as read"),
    )
    arm = settings.arms[settings.comparisons.memory.arm]
    caption = (
        f"{arm.system}, {arm.memory} (static gate), on the past relations, asked as they are meant and as if the other had been "
        "said. Same answer: of the episodes answered as they are meant, those with the same point either way."
    )
    return Table(caption, columns, relations)
