"""The table of coverage: success where an agent answers only what it is surest of."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import numbers, percent, range_column, span, three, words
from ovman.report.tables.table import CSV_AND_MARKDOWN, DATA, SECTION, Table
from ovman.settings import Settings

SHOWN = (0.25, 0.5, 0.75, 1.0)
"""Coverages that a page shows; the csv file has all."""


def coverage_table(rows: pd.DataFrame, settings: Settings) -> Table:
    """A row a split, agent and coverage. rows: of `Coverage`."""
    shown = rows[rows["coverage"].isin(SHOWN)]
    frame = shown.assign(
        system=[settings.arms[arm].system for arm in shown["arm"]],
        range=[span(low, high) for low, high in zip(shown["low"], shown["high"], strict=True)],
    )
    # Not by +: the columns of a frame without rows have no common type.
    frame[SECTION] = [f"{split}, {system}" for split, system in zip(frame["split"], frame["system"], strict=True)]
    columns = (
        words("split", formats=CSV_AND_MARKDOWN),
        words("system", formats=CSV_AND_MARKDOWN),
        words("arm", formats=DATA),
        numbers("coverage", data=three),
        numbers("answered"),
        numbers("least_confidence", "least confidence", three),
        numbers("successes"),
        numbers("rate", "success", three),
        range_column(settings.evaluation.confidence),
    )
    caption = (
        "Success on the static gate where an agent answers only the episodes of which it is surest, by coverage, the share of "
        "the episodes that are answered. Least confidence: of the answers that are given, as the agent itself holds them. Ranges "
        f"are Wilson {percent(settings.evaluation.confidence)} intervals."
    )
    return Table(caption, columns, frame.drop(columns=["low", "high"]), wide=False)
