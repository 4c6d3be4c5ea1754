"""How far the margin of memory depends on the thresholds of admissibility: its range with each value of each of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from ovman.report.figures.canvas import AMBER, COLUMN_IN, DARK, INK, LEGEND, LIGHT, PALE, SMALL_PT, TYPE_PT, absent, drawing
from ovman.report.paper_comparison.metrics import Metrics, Missing
from ovman.report.paper_comparison.paper import Paper
from ovman.report.tables.sensitivity import TITLES
from ovman.settings.sensitivity import THRESHOLDS

LEAST, GREATEST = "static_margin_least", "static_margin_greatest"
"""Keys of the paper's range."""
SHADES = (LIGHT, DARK)
"""Of the lower and of the higher value of a threshold."""


def draw(metrics: Metrics, paper: Paper, output: Path) -> None:
    """Write a bar from the least to the greatest margin for each value of each threshold, the margin in force, the paper's."""
    with drawing(output) as plt:
        figure, axis = plt.subplots(figsize=(COLUMN_IN, 3.3), layout="constrained")
        figure.supxlabel(
            "success with two visits less success with one, static gate\nbars: least to greatest of all settings with the value",
            fontsize=TYPE_PT,
        )
        try:
            rows = metrics.frame("sensitivity")
        except Missing as missing:
            absent(axis, str(missing))
            return
        _bars(axis, rows[rows["in_force"] != "1"])
        for margin in rows.loc[(rows["in_force"] == "1") & (rows["margin"] != ""), "margin"].tolist():
            axis.axvline(float(margin), color=INK, linewidth=0.8, linestyle=(0, (3, 2)), label="thresholds in force", zorder=4)
        low, high = (paper[key].value for key in (LEAST, GREATEST))
        if low is not None and high is not None:
            axis.axvspan(low, high, color=AMBER, alpha=0.5, linewidth=0, label="range of the paper", zorder=1)
        axis.axvline(0.0, color=INK, linewidth=0.6, zorder=1)
        for colour, label in zip(SHADES, ("lower value", "higher value"), strict=True):
            axis.barh(0, 0, color=colour, label=label)
        figure.legend(**(LEGEND | {"loc": "outside upper center", "ncols": 2}))


def _bars(axis: Any, rows: pd.DataFrame) -> None:
    names, places = list(THRESHOLDS), []
    for number, name in enumerate(names):
        values = sorted(set(rows[name]), key=float)
        for step, value in enumerate(values):
            margins = [float(text) for text in rows.loc[rows[name] == value, "margin"] if text]
            if not margins:
                continue
            place = number + (step - (len(values) - 1) / 2) * 0.8 / len(values)
            axis.barh(place, max(margins) - min(margins), 0.7 / len(values), min(margins), color=SHADES[step % 2], zorder=2)
            axis.annotate(
                f"{float(value):g}", (max(margins), place), (2, 0), textcoords="offset points", va="center", fontsize=SMALL_PT
            )
        places.append(number)
    axis.set_yticks(places, [TITLES[name] for name in names])
    axis.invert_yaxis()
    axis.grid(axis="x", color=PALE, linewidth=0.5)
    axis.set_axisbelow(True)
    axis.tick_params(colors=INK, length=0, pad=2)
    axis.margins(x=0.12)
    for side in ("top", "right", "left"):
        axis.spines[side].set_visible(False)
