"""Success by relation, one maintained map against two visits (the paper's Fig. memory)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.records.relation import Relation
from ovman.report.figures.canvas import COLUMN_IN, DARK, DIAMOND, LIGHT, bar, drawing, framed, lettered
from ovman.report.paper_comparison.comparison import static
from ovman.report.paper_comparison.metrics import Metrics
from ovman.report.paper_comparison.paper import Paper

WIDTH = 0.4


@dataclass(frozen=True, slots=True)
class Panel:
    """Two readings of the same maps by relation, as rows of the paper.

    one: the row of an arm that reads one state; two: the row of one that reads two visits; theirs: the row that has the paper's
    figures for `one`.
    """

    title: str
    one: str
    two: str
    theirs: str


OURS = (
    Panel("reference agent,\nown grounding", "static.maintained", "static.two", "static.one"),
    Panel("reference agent,\noracle grounding", "static.grounding_maintained", "static.grounding_two", "static.grounding_one"),
)
DUALMAP = (
    Panel("DualMap,\nown grounding", "static.dualmap_one", "static.dualmap_two", "static.dualmap_one"),
    Panel(
        "DualMap,\noracle grounding",
        "static.grounding_dualmap_one",
        "static.grounding_dualmap_two",
        "static.grounding_dualmap_one",
    ),
)


def draw(metrics: Metrics, paper: Paper, output: Path) -> None:
    """Write bars with intervals; diamonds are the paper's.

    The reference agent's maps on the left and DualMap's on the right, with own grounding above and oracle grounding below.
    The right side is left out without metrics of DualMap.
    """
    there = any(metrics.find(static(row)) for panel in DUALMAP for row in (panel.one, panel.two))
    sides = [OURS, DUALMAP] if there else [OURS]
    with drawing(output) as plt:
        figure, axes = plt.subplots(
            2, len(sides), figsize=(COLUMN_IN, 3.5), squeeze=False, sharex=True, sharey=True, layout="constrained"
        )
        for column, panels in enumerate(sides):
            for row, (axis, panel) in enumerate(zip(axes[:, column], panels, strict=True)):
                _panel(axis, metrics, paper, panel)
                lettered(axis, "abcd"[row * len(sides) + column], panel.title)
                framed(axis, "success, static gate" if column == 0 else None)
        handles, words = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, words, frameon=False, handlelength=1.2, loc="outside upper center", ncols=3)


def _panel(axis: Any, metrics: Metrics, paper: Paper, panel: Panel) -> None:
    for offset, row, printed, colour, words in (
        (-WIDTH / 2, panel.one, panel.theirs, LIGHT, "one maintained map"),
        (WIDTH / 2, panel.two, panel.two, DARK, "two visits"),
    ):
        for place, relation in enumerate(Relation):
            first = place == 0
            ends = [metrics.find(static(row, relation, column)) for column in ("rate", "low", "high")]
            if all(ends):
                rate, low, high = (end.value for end in ends if end)
                bar(axis, place + offset, (rate, low, high), WIDTH - 0.02, colour, words if first else None)
            key = f"{printed}.{relation}"
            if key in paper:
                label = "paper" if first and row == panel.two else None
                axis.plot(place + offset, paper[key].value, label=label, zorder=4, **DIAMOND)
    axis.set_xticks(range(len(Relation)), [relation.value for relation in Relation], rotation=90)
