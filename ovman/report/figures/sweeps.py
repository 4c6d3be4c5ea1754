"""Draw what follows from given parts and thresholds: the error budget, the association gate, the thresholds of admissibility."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import pandas as pd

from ovman.report.figures.canvas import (
    ABOVE,
    AMBER,
    COLUMN_IN,
    DARK,
    INK,
    LEGEND,
    LIGHT,
    PALE,
    SMALL_PT,
    TYPE_PT,
    draw_bar,
    frame_rates,
    open_canvas,
    set_heading,
    strip_frame,
    write_rate,
)
from ovman.report.metrics import Metrics
from ovman.report.paper import PAPER
from ovman.report.tables.perception import THRESHOLD_TITLES
from ovman.settings import Settings
from ovman.settings.comparisons import THRESHOLDS

GIVEN = "answer_given"
"""Key of the paper's figure of the last rung, which has no row in its tables."""
DASHES = (0, (3, 2))


def draw_budget(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw the paper's Fig. diag: success with ever more of the agent replaced by the truth, and by association gate.

    The gate in force is marked, and so is the least displacement that is asked about, which the gate must not reach.
    """
    with open_canvas(output) as plt:
        _, (above, below) = plt.subplots(2, 1, figsize=(COLUMN_IN, 3.3), layout="constrained", height_ratios=[1.2, 1])
        set_heading(above, "a", "error budget")
        _draw_rungs(above, metrics, settings)
        set_heading(below, "b", "association gate")
        _draw_gates(below, metrics)


def _draw_rungs(axis: Any, metrics: Metrics, settings: Settings, half: float = 0.19) -> None:
    """Draw two bars per rung, ours and the paper's; the paper has no figure of some rungs."""
    rungs: list[Any] = list(metrics.rows("budget").frame.itertuples())
    for place, row in enumerate(rungs):
        # The last rung is true by definition and has no interval.
        ends = row.rate, *(row.rate if pd.isna(end) else end for end in (row.low, row.high))
        draw_bar(axis, place - half, ends, 2 * half - 0.02, DARK, None if place else "here")
        write_rate(axis, place - half, row.rate, ends[2])
        key = f"static.{settings.paper.static[row.arm]}.all" if row.arm in settings.paper.static else "" if row.arm else GIVEN
        if key in PAPER:
            printed = PAPER[key].low
            axis.bar(place + half, printed, 2 * half - 0.02, color=PALE, label=None if place else "paper", zorder=2)
            write_rate(axis, place + half, printed, printed)
    axis.set_xticks(range(len(rungs)), [textwrap.fill(row.rung, 11) for row in rungs])
    frame_rates(axis, "success, static gate")
    axis.set_ylim(0, 1.14)
    axis.legend(ncols=2, **ABOVE)


def _draw_gates(axis: Any, metrics: Metrics) -> None:
    rows = metrics.frame("gate_sweep")
    axis.set_xlabel("objects farther apart than this are not matched, m")
    frame_rates(axis, "success, static gate")
    axis.fill_between(rows["gate_m"], rows["low"], rows["high"], color=LIGHT, alpha=0.6, linewidth=0, zorder=2)
    axis.plot(rows["gate_m"], rows["success"], color=DARK, linewidth=1.2, marker="o", markersize=2.2, zorder=3)
    for gate in rows[rows["in_force"] == 1].itertuples():
        axis.axvline(gate.gate_m, color=INK, linewidth=0.8, linestyle=DASHES, label="in force", zorder=4)
        axis.axvline(gate.delta_min_m, color=AMBER, linewidth=1.0, label="least displacement", zorder=4)
    axis.legend(ncols=2, **ABOVE)


def draw_sensitivity(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw how far the margin of memory depends on the thresholds of admissibility.

    A bar goes from the least to the greatest margin of all settings with one value of one threshold. The margin in force and the
    paper's range are marked.
    """
    rows = metrics.frame("sensitivity").dropna(subset="margin")
    shades = {"lower value": LIGHT, "higher value": DARK}
    with open_canvas(output) as plt:
        figure, axis = plt.subplots(figsize=(COLUMN_IN, 3.3), layout="constrained")
        figure.supxlabel(
            "success with two visits less success with one, static gate\nbars: least to greatest of all settings with the value",
            fontsize=TYPE_PT,
        )
        _draw_ranges(axis, rows[rows["in_force"] == 0], list(shades.values()))
        for margin in rows.loc[rows["in_force"] == 1, "margin"]:
            axis.axvline(margin, color=INK, linewidth=0.8, linestyle=DASHES, label="thresholds in force", zorder=4)
        low, high = PAPER["static_margin_least"].low, PAPER["static_margin_greatest"].high
        axis.axvspan(low, high, color=AMBER, alpha=0.5, linewidth=0, label="range of the paper", zorder=1)
        axis.axvline(0.0, color=INK, linewidth=0.6, zorder=1)
        for label, colour in shades.items():
            axis.barh(0, 0, color=colour, label=label)
        figure.legend(**(LEGEND | {"loc": "outside upper center", "ncols": 2}))


def _draw_ranges(axis: Any, rows: pd.DataFrame, shades: list[str]) -> None:
    for number, name in enumerate(THRESHOLDS):
        ranges = rows.groupby(name)["margin"].agg(["min", "max"])
        for step, (value, least, greatest) in enumerate(ranges.itertuples()):
            place = number + (step - (len(ranges) - 1) / 2) * 0.8 / len(ranges)
            axis.barh(place, greatest - least, 0.7 / len(ranges), least, color=shades[step % 2], zorder=2)
            style = {"textcoords": "offset points", "va": "center", "fontsize": SMALL_PT}
            axis.annotate(f"{value:g}", (greatest, place), (2, 0), **style)
    axis.set_yticks(range(len(THRESHOLDS)), [THRESHOLD_TITLES[name] for name in THRESHOLDS])
    axis.invert_yaxis()
    strip_frame(axis, "x")
    axis.margins(x=0.12)
