"""Static success of agents, controls and chance on the first split and on the last, where more changes than the answer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from ovman.report.figures.canvas import ABOVE, AMBER, COLUMN_IN, DARK, INK, PALE, SMALL_PT, absent, drawing
from ovman.report.paper_comparison.metrics import ALL, Metrics, Missing
from ovman.settings import Kind, Settings
from ovman.settings.arms import Withheld

CHANCE = "chance among what changed"
"""Title of the row of column chance_of_change: a random pick of the changes of the kind that defines the episode."""
AGENTS, CONTROLS = "agents", "controls"
_COLUMNS = ["split", "block", "title", "rate", "low", "high"]
_ROW_IN = 0.235
_APART = 0.15
"""Half the distance between the two dots of a row, as a share of its height."""


def draw(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Write two dots with intervals for each arm of comparisons.controls: static success on the first split and on the last.

    Of the controls, those that are asked about another noun, relation or visit are left to the table.
    """
    try:
        rows, missing = _read(metrics, settings), "controls.csv has no static arm"
    except Missing as error:
        rows, missing = pd.DataFrame(columns=_COLUMNS), str(error)
    splits = list(dict.fromkeys(rows["split"]))
    ends = list(dict.fromkeys((*splits[:1], *splits[-1:])))
    rows = rows[rows["split"].isin(ends)]
    blocks = [block for name in (AGENTS, CONTROLS, "") if len(block := rows[rows["block"] == name])]
    lines = sum(1 + block["title"].nunique() for block in blocks)
    with drawing(output) as plt:
        _, axis = plt.subplots(figsize=(COLUMN_IN, max(2.0, 0.6 + _ROW_IN * lines)), layout="constrained")
        axis.set_xlabel("success on the static gate, all relations")
        if not blocks:
            absent(axis, missing)
            return
        _frame(axis)
        place, places, titles = 0.0, [], []
        for block, colour in zip(blocks, (DARK, AMBER, INK), strict=False):
            heading = block["block"].iloc[0]
            if heading:
                places.append(place)
                titles.append(heading)
            else:
                place -= 0.5
            for title in dict.fromkeys(block["title"]):
                place += 1
                _line(axis, place, block[block["title"] == title], ends, colour)
                places.append(place)
                titles.append(title)
            place += 1
        for label in axis.set_yticks(places, titles) and axis.get_yticklabels():
            label.set_fontstyle("italic" if label.get_text() in (AGENTS, CONTROLS) else "normal")
        axis.set_ylim(place - 0.4, -0.6)
        for face, split in zip(("white", INK)[-len(ends) :], ends, strict=True):
            axis.plot([], [], "o", markerfacecolor=face, markeredgecolor=INK, markersize=4.2, label=f"split {split}")
        axis.legend(**(ABOVE | {"ncols": 2, "handlelength": 0.8}))


def _read(metrics: Metrics, settings: Settings) -> pd.DataFrame:
    """Return the rows of the figure, those with the highest rate on the first split first. Raises Missing without metrics."""
    rows = metrics.frame("controls")
    rows = rows[(rows["kind"] == Kind.STATIC) & (rows["relation"] == ALL)]
    shown = [arm for arm in dict.fromkeys(rows["arm"]) if settings.arms[arm].withheld in (None, Withheld.NOUN)]
    arms = rows[rows["arm"].isin(shown)]
    arms = arms.assign(
        block=["controls" if sign == "1" else "agents" for sign in arms["control"]],
        title=[settings.comparisons.controls[arm].title or settings.arms[arm].system for arm in arms["arm"]],
    )
    of_splits = rows.drop_duplicates("split")
    rates = dict.fromkeys(("rate", "low", "high"), of_splits["chance_of_change"])
    found = pd.concat([arms, of_splits.assign(block="", title=CHANCE, **rates)])
    found = found[_COLUMNS].astype({"rate": float, "low": float, "high": float})
    first = found.drop_duplicates("title").set_index("title")["rate"]
    return found.iloc[(-found["title"].map(first)).argsort(kind="stable")]


def _line(axis: Any, place: float, rows: pd.DataFrame, ends: list[str], colour: str) -> None:
    """The dots of one row with their intervals: hollow on the first split, filled on the last."""
    of = {split: row for split, *row in rows[["split", "rate", "low", "high"]].to_numpy().tolist()}
    rates = [rate for rate, *_ in of.values()]
    axis.plot((min(rates), max(rates)), (place, place), color=PALE, linewidth=2.4, solid_capstyle="butt", zorder=1)
    for number, split in enumerate(ends):
        if split not in of:
            continue
        rate, low, high = of[split]
        last = number == len(ends) - 1
        at = place if len(ends) == 1 else place + (_APART if last else -_APART)
        axis.plot((low, high), (at, at), color=colour, linewidth=0.8, zorder=2)
        face = colour if last else "white"
        axis.plot(rate, at, "o", markersize=4.2, markerfacecolor=face, markeredgecolor=colour, markeredgewidth=1.0, zorder=3)
        right = rate > min(rates) or len(set(rates)) == 1
        at_edge = ((high, at), (3, 0)) if right else ((low, at), (-3, 0))
        style = {"textcoords": "offset points", "va": "center", "ha": "left" if right else "right", "fontsize": SMALL_PT}
        axis.annotate(f"{rate:.3f}", *at_edge, **style)


def _frame(axis: Any) -> None:
    axis.set_xlim(-0.14, 1.18)
    axis.set_xticks([0, 0.2, 0.4, 0.6, 0.8, 1.0])
    axis.grid(axis="x", color=PALE, linewidth=0.5)
    axis.set_axisbelow(True)
    axis.tick_params(colors=INK, length=0, pad=3)
    for side in ("top", "right", "left"):
        axis.spines[side].set_visible(False)
