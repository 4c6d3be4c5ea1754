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
    say_missing,
    set_heading,
    strip_frame,
    write_rate,
)
from ovman.report.metrics import ALL, Metrics, Missing
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
    try:
        rows = metrics.frame("budget")
        rungs: list[Any] = list(rows[rows["relation"] == ALL].itertuples())
    except Missing:
        rungs = []
    ours = theirs = False
    for place, row in enumerate(rungs):
        of_rung = metrics.rows("budget", rung=row.rung)
        rate, low, high = (of_rung.one(column) for column in ("rate", "low", "high"))
        if not rate.missing:
            # The last rung is true by definition and has no interval.
            ends = (rate, rate if low.missing else low, rate if high.missing else high)
            draw_bar(axis, place - half, ends, 2 * half - 0.02, DARK, None if ours else "here")
            write_rate(axis, place - half, rate, ends[2])
            ours = True
        key = f"static.{settings.paper.static[row.arm]}.all" if row.arm in settings.paper.static else "" if row.arm else GIVEN
        if key in PAPER and (printed := PAPER[key].value) is not None:
            axis.bar(place + half, printed, 2 * half - 0.02, color=PALE, label=None if theirs else "paper", zorder=2)
            write_rate(axis, place + half, printed, printed)
            theirs = True
    axis.set_xticks(range(len(rungs)), [textwrap.fill(str(row.rung), 11) for row in rungs])
    frame_rates(axis, "success, static gate")
    axis.set_ylim(0, 1.14)
    if ours or theirs:
        axis.legend(ncols=2, **ABOVE)


def _draw_gates(axis: Any, metrics: Metrics) -> None:
    axis.set_xlabel("objects farther apart than this are not matched, m")
    frame_rates(axis, "success, static gate")
    try:
        rows = metrics.frame("gate_sweep")
    except Missing as missing:
        say_missing(axis, str(missing))
        return
    in_force = rows[rows["in_force"] == "1"]
    rows = rows[["gate_m", "success", "low", "high"]].astype(float).sort_values("gate_m", kind="stable")
    axis.fill_between(rows["gate_m"], rows["low"], rows["high"], color=LIGHT, alpha=0.6, linewidth=0, zorder=2)
    axis.plot(rows["gate_m"], rows["success"], color=DARK, linewidth=1.2, marker="o", markersize=2.2, zorder=3)
    for gate_m, delta_min_m in in_force[["gate_m", "delta_min_m"]].astype(float).to_numpy().tolist():
        axis.axvline(gate_m, color=INK, linewidth=0.8, linestyle=DASHES, label="in force", zorder=4)
        axis.axvline(delta_min_m, color=AMBER, linewidth=1.0, label="least displacement", zorder=4)
    if len(in_force):
        axis.legend(ncols=2, **ABOVE)


def draw_sensitivity(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Draw how far the margin of memory depends on the thresholds of admissibility.

    A bar goes from the least to the greatest margin of all settings with one value of one threshold. The margin in force and the
    paper's range are marked.
    """
    shades = {"lower value": LIGHT, "higher value": DARK}
    with open_canvas(output) as plt:
        figure, axis = plt.subplots(figsize=(COLUMN_IN, 3.3), layout="constrained")
        figure.supxlabel(
            "success with two visits less success with one, static gate\nbars: least to greatest of all settings with the value",
            fontsize=TYPE_PT,
        )
        try:
            rows = metrics.frame("sensitivity")
        except Missing as missing:
            say_missing(axis, str(missing))
            return
        _draw_ranges(axis, rows[rows["in_force"] != "1"], list(shades.values()))
        for margin in rows.loc[(rows["in_force"] == "1") & (rows["margin"] != ""), "margin"].tolist():
            axis.axvline(float(margin), color=INK, linewidth=0.8, linestyle=DASHES, label="thresholds in force", zorder=4)
        low, high = PAPER["static_margin_least"].low, PAPER["static_margin_greatest"].high
        axis.axvspan(low, high, color=AMBER, alpha=0.5, linewidth=0, label="range of the paper", zorder=1)
        axis.axvline(0.0, color=INK, linewidth=0.6, zorder=1)
        for label, colour in shades.items():
            axis.barh(0, 0, color=colour, label=label)
        figure.legend(**(LEGEND | {"loc": "outside upper center", "ncols": 2}))


def _draw_ranges(axis: Any, rows: pd.DataFrame, shades: list[str]) -> None:
    names = list(THRESHOLDS)
    for number, name in enumerate(names):
        values = sorted(set(rows[name]), key=float)
        for step, value in enumerate(values):
            margins = [float(text) for text in rows.loc[rows[name] == value, "margin"] if text]
            if not margins:
                continue
            place = number + (step - (len(values) - 1) / 2) * 0.8 / len(values)
            axis.barh(place, max(margins) - min(margins), 0.7 / len(values), min(margins), color=shades[step % 2], zorder=2)
            at, style = (max(margins), place), {"textcoords": "offset points", "va": "center", "fontsize": SMALL_PT}
            axis.annotate(f"{float(value):g}", at, (2, 0), **style)
    axis.set_yticks(range(len(names)), [THRESHOLD_TITLES[name] for name in names])
    axis.invert_yaxis()
    strip_frame(axis, "x")
    axis.margins(x=0.12)
