"""The paper's Fig. diag: (a) success with ever more of the agent replaced by the truth, (b) success by association gate."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

from ovman.report.figures.canvas import (
    ABOVE,
    AMBER,
    COLUMN_IN,
    DARK,
    INK,
    LIGHT,
    PALE,
    absent,
    bar,
    drawing,
    framed,
    lettered,
    value,
)
from ovman.report.paper_comparison.metrics import ALL, Metrics, Missing, Reading
from ovman.report.paper_comparison.paper import Paper
from ovman.settings import Settings

GIVEN = "answer_given"
"""Key of the paper's figure of the last rung, which has no row in its tables."""
TITLE_WIDTH = 11
_HALF = 0.19


def draw(metrics: Metrics, paper: Paper, settings: Settings, output: Path) -> None:
    """Write both parts. The gate in force is marked, and the least displacement that is asked about, which it must not reach."""
    with drawing(output) as plt:
        _, (above, below) = plt.subplots(2, 1, figsize=(COLUMN_IN, 3.3), layout="constrained", height_ratios=[1.2, 1])
        lettered(above, "a", "error budget")
        _rungs(above, metrics, paper, settings)
        lettered(below, "b", "association gate")
        _gates(below, metrics)


def _rungs(axis: Any, metrics: Metrics, paper: Paper, settings: Settings) -> None:
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


def _gates(axis: Any, metrics: Metrics) -> None:
    axis.set_xlabel("objects farther apart than this are not matched, m")
    framed(axis, "success, static gate")
    try:
        rows = metrics.frame("gate_sweep")
    except Missing as missing:
        absent(axis, str(missing))
        return
    in_force = rows[rows["in_force"] == "1"]
    rows = rows[["gate_m", "success", "low", "high"]].astype(float).sort_values("gate_m", kind="stable")
    axis.fill_between(rows["gate_m"], rows["low"], rows["high"], color=LIGHT, alpha=0.6, linewidth=0, zorder=2)
    axis.plot(rows["gate_m"], rows["success"], color=DARK, linewidth=1.2, marker="o", markersize=2.2, zorder=3)
    for gate_m, delta_min_m in in_force[["gate_m", "delta_min_m"]].astype(float).to_numpy().tolist():
        axis.axvline(gate_m, color=INK, linewidth=0.8, linestyle=(0, (3, 2)), label="in force", zorder=4)
        axis.axvline(delta_min_m, color=AMBER, linewidth=1.0, label="least displacement", zorder=4)
    if len(in_force):
        axis.legend(ncols=2, **ABOVE)
