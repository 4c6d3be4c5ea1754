"""The error budget: success of the two-visit agent with one source of error more handed over at each rung."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

from ovman.models.settings import Settings
from ovman.report.figures.canvas import ABOVE, COLUMN_IN, DARK, PALE, bar, drawing, framed, value
from ovman.report.paper_comparison.metrics import ALL, Metrics, Missing, Reading
from ovman.report.paper_comparison.paper import Paper

GIVEN = "answer_given"
"""Key of the paper's figure of the last rung, which has no row in its tables."""
TITLE_WIDTH = 11
_HALF = 0.19


def draw(metrics: Metrics, paper: Paper, settings: Settings, output: Path) -> None:
    """Write the rungs alone: ours with intervals, the paper's beside them."""
    with drawing(output) as plt:
        _, axis = plt.subplots(figsize=(COLUMN_IN, 1.9), layout="constrained")
        rungs(axis, metrics, paper, settings)


def rungs(axis: Any, metrics: Metrics, paper: Paper, settings: Settings) -> None:
    """Two bars a rung, the metrics' titles below; a rung of which the paper has no figure has one."""
    titles = [str(row.rung) for row in _rows(metrics)]
    ours = theirs = False
    for place, row in enumerate(_rows(metrics)):
        found = [
            metrics.find(Reading(file="budget", where={"rung": row.rung}, column=column)) for column in ("rate", "low", "high")
        ]
        rate, low, high = (None if cell is None else cell.value for cell in found)
        if rate is not None:
            # The last rung is true by definition and has no interval.
            ends = (rate, rate if low is None else low, rate if high is None else high)
            bar(axis, place - _HALF, ends, 2 * _HALF - 0.02, DARK, None if ours else "here")
            value(axis, place - _HALF, rate, ends[2])
            ours = True
        key = f"static.{settings.paper.static[row.arm]}.all" if row.arm in settings.paper.static else "" if row.arm else GIVEN
        if key in paper and (printed := paper[key].value) is not None:
            axis.bar(place + _HALF, printed, 2 * _HALF - 0.02, color=PALE, label=None if theirs else "paper", zorder=2)
            value(axis, place + _HALF, printed, printed)
            theirs = True
    axis.set_xticks(range(len(titles)), [textwrap.fill(title, TITLE_WIDTH) for title in titles])
    framed(axis, "success, static gate")
    axis.set_ylim(0, 1.14)
    if ours or theirs:
        axis.legend(ncols=2, **ABOVE)


def _rows(metrics: Metrics) -> list[Any]:
    try:
        rows = metrics.frame("budget")
    except Missing:
        return []
    return list(rows[rows["relation"] == ALL].itertuples())
