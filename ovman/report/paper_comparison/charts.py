"""The two charts of the page: the error budget, and success by relation with two visits against a reading of one state."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.report.paper_comparison.comparison import RELATIONS, static
from ovman.report.paper_comparison.metrics import Metrics
from ovman.report.paper_comparison.paper import Paper

DARK, LIGHT, INK, PALE = "#1f5a94", "#a9c9e6", "#24292f", "#d0d7de"
RUNGS = (
    ("static.two", "own perception"),
    ("static.grounding_two", "grounding handed over"),
    ("static.positions_two", "positions handed over"),
)
"""Rows of the paper in the chart of the error budget, each with its title."""
DIAMOND = {"marker": "D", "markersize": 5, "markerfacecolor": "white"}
ABOVE = {"textcoords": "offset points", "ha": "center", "fontsize": 9, "color": INK}
DPI = 150
# Which release of the library wrote it is no part of the picture.
PLAIN = {"Software": None}


def budget(metrics: Metrics, paper: Paper, output: Path) -> None:
    """Success of the two-visit agent with each source of error handed over: bars of ours with intervals, beside the paper's."""
    plt = _pyplot()
    figure, axis = plt.subplots(figsize=(7.6, 2.9))
    for place, (row, _) in enumerate(RUNGS):
        theirs, first = _paper(paper, f"{row}.all"), place == 0
        if ours := _bar(axis, metrics, place - 0.2, row, "all", DARK, "here" if first else None):
            axis.annotate(f"{ours[0]:.3f}", (place - 0.2, ours[1]), (0, 3), **ABOVE)
        axis.bar(place + 0.2, theirs, 0.36, color=PALE, label="paper" if first else None, zorder=2)
        axis.annotate(f"{theirs:.3f}", (place + 0.2, theirs), (0, 3), **ABOVE)
    axis.set_xticks(range(len(RUNGS)), [words for _, words in RUNGS])
    axis.legend(frameon=False, ncols=2, loc="upper left")
    _framed(axis, "success, static gate")
    figure.tight_layout(pad=0.5)
    _saved(plt, figure, output)


@dataclass(frozen=True, slots=True)
class Panel:
    """Two readings of the same maps by relation, as rows of the paper.

    one: the row of an arm that reads one state; words: what the legend calls it; two: the row of one that reads two visits.
    """

    title: str
    one: str
    two: str
    words: str


OURS = (
    Panel("our maps, own grounding", "static.one", "static.two", "one visit (expected)"),
    Panel("our maps, grounding handed over", "static.grounding_one", "static.grounding_two", "one visit (expected)"),
)
DUALMAP = (
    Panel("DualMap's maps, own grounding", "static.dualmap_one", "static.dualmap_two", "one maintained map"),
    Panel(
        "DualMap's maps, grounding handed over",
        "static.grounding_dualmap_one",
        "static.grounding_dualmap_two",
        "one maintained map",
    ),
)


def memory(metrics: Metrics, paper: Paper, output: Path) -> None:
    """Static success by relation, a reading of one state against two visits: bars with intervals; diamonds are the paper's.

    Our maps on the left and DualMap's on the right, with own grounding above and handed over below (the paper's Fig. memory).
    Without metrics of DualMap there is no right side.
    """
    plt = _pyplot()
    there = any(metrics.find(static(row)) for panel in DUALMAP for row in (panel.one, panel.two))
    sides = [OURS, DUALMAP] if there else [OURS]
    figure, axes = plt.subplots(2, len(sides), figsize=(7.6 if len(sides) == 1 else 12.4, 6.0), squeeze=False)
    for column, panels in enumerate(sides):
        for axis, panel in zip(axes[:, column], panels, strict=True):
            _panel(axis, metrics, paper, panel)
            _framed(axis, "success, static gate" if column == 0 else None)
    figure.tight_layout(pad=0.5, h_pad=1.5, w_pad=2.0)
    _saved(plt, figure, output)


def _panel(axis: Any, metrics: Metrics, paper: Paper, panel: Panel) -> None:
    for offset, row, colour, words in ((-0.2, panel.one, LIGHT, panel.words), (0.2, panel.two, DARK, "two visits")):
        for place, relation in enumerate(RELATIONS):
            theirs, first = _paper(paper, f"{row}.{relation}"), place == 0
            label = "paper" if first and row == panel.two else None
            axis.plot(place + offset, theirs, color=INK, linestyle="", label=label, zorder=4, **DIAMOND)
            _bar(axis, metrics, place + offset, row, relation, colour, words if first else None)
    axis.set_xticks(range(len(RELATIONS)), [relation.upper() for relation in RELATIONS], fontsize=8)
    axis.set_title(panel.title, loc="left", fontsize=9, color=INK, pad=18)
    axis.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(-0.02, 0.97), fontsize=8)


def _bar(
    axis: Any, metrics: Metrics, place: float, row: str, relation: str, colour: str, label: str | None
) -> tuple[float, float] | None:
    """Draws a static rate of ours with its interval. The rate and the upper end; None, and nothing drawn, without metrics."""
    rate, low, high = (metrics.find(static(row, relation, column)) for column in ("rate", "low", "high"))
    if rate is None or low is None or high is None:
        return None
    reach = [[max(0.0, rate.value - low.value)], [max(0.0, high.value - rate.value)]]
    axis.bar(place, rate.value, 0.36, color=colour, label=label, zorder=2)
    axis.errorbar(place, rate.value, reach, color=INK, linewidth=0.8, capsize=2, zorder=3)
    return rate.value, high.value


def _paper(paper: Paper, key: str) -> float:
    value = paper[key].value
    assert value is not None, key
    return value


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def _framed(axis: Any, title: str | None) -> None:
    axis.set_ylim(0, 1.09)
    if title:
        axis.set_ylabel(title, color=INK)
    axis.grid(axis="y", color=PALE, linewidth=0.6)
    axis.set_axisbelow(True)
    axis.tick_params(colors=INK, length=0)
    for side in ("top", "right", "left"):
        axis.spines[side].set_visible(False)
    axis.spines["bottom"].set_color(PALE)


def _saved(plt: Any, figure: Any, output: Path) -> None:
    figure.savefig(output, dpi=DPI, format="png", facecolor="white", metadata=PLAIN)
    plt.close(figure)
