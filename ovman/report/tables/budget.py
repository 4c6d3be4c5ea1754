"""The table of the error budget."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import ALL, numbers, p_values, percent, range_column, signed, span, three, words
from ovman.report.tables.table import DATA, Table
from ovman.settings import Settings, Source


def budget_table(steps: pd.DataFrame, settings: Settings) -> Table:
    """The rungs over all episodes. steps: rows of `Step`."""
    confidence = settings.evaluation.confidence
    here = [settings.arms[arm] for arm in settings.comparisons.rungs if arm in settings.arms]
    read = dict.fromkeys(str(arm.reading) for arm in here if arm.grounding is Source.HANDED and arm.positions is Source.OWN)
    rows = steps[steps["relation"] == ALL].drop(columns=["relation", "successes"])
    rows["range"] = [span(low, high) for low, high in zip(rows["low"], rows["high"], strict=True)]
    columns = (
        words("rung"),
        words("arm", formats=DATA),
        numbers("rate", data=three),
        numbers("low", data=three, formats=DATA),
        numbers("high", data=three, formats=DATA),
        range_column(confidence),
        numbers("gain", data=signed),
        numbers("gained"),
        numbers("lost"),
        p_values("p", "p"),
        numbers("n"),
    )
    caption = (
        "Error budget of the reference agent, static gate: each rung replaces one more part by the truth. Gained, lost: "
        "episodes, against the line above; p: exact two-sided McNemar test. The answer given succeeds by definition. "
        f"Oracle grounding is by the reading {', '.join(read) or 'of no arm'} (table readings). "
        f"Ranges are Wilson {percent(confidence)} intervals."
    )
    return Table(caption, columns, rows)
