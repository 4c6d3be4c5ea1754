"""Controls beside the agents and chance, static success by relation, a panel a split."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from ovman.models.relation import Relation
from ovman.models.settings import Kind, Settings
from ovman.report.figures.canvas import AMBER, COLUMN_IN, DARK, INK, LIGHT, SMALL_PT, absent, bar, drawing, framed, lettered
from ovman.report.figures.memory import SHORT
from ovman.report.paper_comparison.metrics import ALL, Metrics, Missing

CHANCES = {"chance": ("1/n", ":"), "chance_of_change": ("1/m", "--")}
"""What a chance is called, and the style of its line, by column."""
_SHADES = (LIGHT, DARK, "#0c2f52")
"""Of agents, in turn."""
_WIDTH = 0.8
_MARKS = ("o", "s", "D", "^", "v", "<", ">", "P", "X", "*")
_COLOURS = (AMBER, "#2f7d4f", "#a33b3b", "#6b4c9a")
"""Of controls, in turn with the marks."""
_PANEL_IN = 1.5


def draw(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Write bars for the agents of comparisons.controls, marks for the controls, and lines for the chances of 1/n and 1/m."""
    try:
        rows = metrics.frame("controls")
        rows, missing = rows[rows["kind"] == Kind.STATIC], "controls.csv has no static arm"
    except Missing as error:
        rows, missing = pd.DataFrame(columns=["split"]), str(error)
    splits = list(dict.fromkeys(rows["split"]))
    height = _PANEL_IN * max(1, len(splits)) + 0.9
    with drawing(output) as plt:
        figure, axes = plt.subplots(max(1, len(splits)), 1, figsize=(COLUMN_IN, height), squeeze=False, layout="constrained")
        for number, (axis, split) in enumerate(zip(axes[:, 0], splits, strict=False)):
            of_split = rows[rows["split"] == split]
            n = of_split.loc[of_split["relation"] == ALL, "n"].iloc[0]
            _panel(axis, of_split, settings)
            lettered(axis, "abcdefgh"[number] if len(splits) > 1 else "", f"split {split}, {n} episodes")
            framed(axis, "success, static gate")
        if splits:
            key = dict(zip(*reversed(axes[0, 0].get_legend_handles_labels()), strict=True))
            titles = dict.fromkeys(_name(arm, settings) for arm in settings.comparisons.controls if arm in settings.arms)
            words = [*(title for title in titles if title in key), *(title for title, _ in CHANCES.values())]
            style = {"frameon": False, "handlelength": 1.2, "fontsize": SMALL_PT}
            figure.legend([key[word] for word in words], words, loc="outside upper center", ncols=2, **style)
        else:
            absent(axes[0, 0], missing)
            framed(axes[0, 0], "success, static gate")


def _panel(axis: Any, rows: pd.DataFrame, settings: Settings) -> None:
    groups = (*(relation.value for relation in Relation), ALL)
    agents, controls = ([*dict.fromkeys(rows.loc[rows["control"] == sign, "arm"])] for sign in ("0", "1"))
    for place, group in enumerate(groups):
        here = rows[rows["relation"] == group].set_index("arm")
        first = place == 0
        for index, arm in enumerate(arm for arm in agents if arm in here.index):
            width = _WIDTH / len(agents)
            rate, low, high = (float(here.loc[arm, column]) for column in ("rate", "low", "high"))
            at = place + (index - (len(agents) - 1) / 2) * width
            bar(axis, at, (rate, low, high), width - 0.02, _SHADES[index % len(_SHADES)], _name(arm, settings) if first else None)
        for index, arm in enumerate(arm for arm in controls if arm in here.index):
            at = place + ((index + 0.5) / len(controls) - 0.5) * _WIDTH
            style = {"marker": _MARKS[index % len(_MARKS)], "color": _COLOURS[index % len(_COLOURS)], "markersize": 3.2}
            label = _name(arm, settings) if first else None
            axis.plot(at, float(here.loc[arm, "rate"]), linestyle="", zorder=5, clip_on=False, label=label, **style)
        if len(here):
            ends = place - _WIDTH / 2, place + _WIDTH / 2
            for column, (title, dashes) in CHANCES.items():
                chance = float(here[column].iloc[0])
                label = title if first else None
                axis.plot(ends, (chance, chance), color=INK, linewidth=0.9, linestyle=dashes, zorder=4, label=label)
    axis.set_xlim(-0.6, len(groups) - 0.4)
    axis.set_xticks(range(len(groups)), [*SHORT.values(), ALL.upper()])


def _name(arm: str, settings: Settings) -> str:
    return settings.comparisons.controls[arm].title or settings.arms[arm].system
