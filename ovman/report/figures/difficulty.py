"""Static success by the number of instances of the queried category, and by scene (the paper's Fig. difficulty)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from ovman.analysis.difficulty import MANY, By
from ovman.report.figures.canvas import (
    ABOVE,
    AMBER,
    COLUMN_IN,
    DARK,
    DIAMOND,
    LIGHT,
    SMALL_PT,
    absent,
    bar,
    drawing,
    framed,
    lettered,
)
from ovman.report.paper_comparison.metrics import Metrics, Missing
from ovman.report.paper_comparison.paper import Paper
from ovman.settings import Settings

_PAPERS = {"2": "success_with_two", "3": "success_with_three", f"{MANY}+": "success_with_more"}
"""Keys of the paper's figures of the agent by group."""
_WIDTH = 0.27


def draw(metrics: Metrics, paper: Paper, settings: Settings, output: Path) -> None:
    """Write (a) the arms of comparisons.difficulty by number of instances, with intervals, diamonds being the paper's agent;
    (b) the agent by scene as bars with intervals, and as dots the other arms that pick nothing at random."""
    with drawing(output) as plt:
        figure, (above, below) = plt.subplots(2, 1, figsize=(COLUMN_IN, 3.6), layout="constrained", height_ratios=[1, 1.15])
        lettered(above, "a", "by instances of the category")
        lettered(below, "b", "by scene")
        try:
            rows = metrics.frame("difficulty")
        except Missing as missing:
            for axis in (above, below):
                absent(axis, str(missing))
                framed(axis, "success, static gate")
            return
        _by_instances(above, rows[rows["by"] == By.INSTANCES], paper, settings)
        _by_scene(below, rows[rows["by"] == By.SCENE], settings)
        handles, words = above.get_legend_handles_labels()
        figure.legend(handles, words, frameon=False, handlelength=1.2, loc="outside upper center", ncols=2)


def _by_instances(axis: Any, rows: pd.DataFrame, paper: Paper, settings: Settings) -> None:
    groups = rows.drop_duplicates("group")
    shown = _shown(rows, settings)
    for place, group in enumerate(groups["group"]):
        for index, arm in enumerate(shown):
            of_arm = rows[(rows["arm"] == arm) & (rows["group"] == group)]
            at = place + (index - (len(shown) - 1) / 2) * _WIDTH
            for ends in _ends(of_arm):
                label = settings.comparisons.difficulty[arm] if place == 0 else None
                bar(axis, at, ends, _WIDTH - 0.02, _colour(index), label)
            if arm == settings.comparisons.agent and (key := _PAPERS.get(group)) in paper:
                axis.plot(at, paper[str(key)].value, label="paper" if place == 0 else None, zorder=4, **DIAMOND)
    words = [f"{group} instances\n({n} episodes)" for group, n in zip(groups["group"], groups["n"], strict=True)]
    axis.set_xticks(range(len(groups)), words)
    framed(axis, "success, static gate")


def _by_scene(axis: Any, rows: pd.DataFrame, settings: Settings) -> None:
    agent = rows[rows["arm"] == settings.comparisons.agent]
    # From the hardest scene to the easiest; of equal ones by name.
    order = agent.assign(rate=agent["rate"].astype(float)).sort_values(["rate", "group"], kind="stable")["group"].to_list()
    for index, arm in enumerate(_shown(rows, settings)):
        if settings.arms[arm].expected:
            continue
        of_arm = rows[rows["arm"] == arm].set_index("group")
        for place, scene in enumerate(order):
            for ends in _ends(of_arm.loc[[scene]] if scene in of_arm.index else of_arm.iloc[:0]):
                if arm == settings.comparisons.agent:
                    bar(axis, place, ends, 0.7, _colour(index))
                else:
                    label = settings.comparisons.difficulty[arm] if place == 0 else None
                    axis.plot(place, ends[0], "o", color=_colour(index), markersize=3, zorder=4, label=label)
    axis.set_xticks(range(len(order)), [scene.removeprefix("FloorPlan") for scene in order], rotation=90, fontsize=SMALL_PT)
    axis.set_xlabel("floor plan")
    axis.legend(**ABOVE)
    axis.set_xlim(-0.6, len(order) - 0.4)
    framed(axis, "success, static gate")


def _shown(rows: pd.DataFrame, settings: Settings) -> list[str]:
    here = {*rows["arm"]}
    return [arm for arm in settings.comparisons.difficulty if arm in here]


def _colour(index: int) -> str:
    return (LIGHT, DARK, AMBER)[index % 3]


def _ends(rows: pd.DataFrame) -> list[tuple[float, float, float]]:
    found = rows[["rate", "low", "high"]].replace("", None).dropna().astype(float)
    return [(rate, low, high) for rate, low, high in found.to_numpy().tolist()]
