"""The two charts of the page: the error budget, and success by relation with two visits against one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ovman.report.findings import sources
from ovman.report.findings.budget import GROUNDING, POSITIONS
from ovman.report.findings.comparison import found
from ovman.report.findings.memory import ONE, TWO
from ovman.report.findings.metrics import Metrics
from ovman.report.findings.paper import Paper
from ovman.report.findings.sources import RELATIONS

DARK, LIGHT, INK, PALE = "#1f5a94", "#a9c9e6", "#24292f", "#d0d7de"
RUNGS = ((TWO, "own perception"), (GROUNDING, "grounding handed over"), (POSITIONS, "positions handed over"))
DIAMOND = {"marker": "D", "markersize": 5, "markerfacecolor": "white"}
ABOVE = {"textcoords": "offset points", "ha": "center", "fontsize": 9, "color": INK}
DPI = 150
# Which release of the library wrote it is no part of the picture.
PLAIN = {"Software": None}


def budget(metrics: Metrics, paper: Paper, output: Path) -> None:
    """Success of the two-visit agent with each source of error handed over: bars of ours with intervals, beside the paper's."""
    plt = _pyplot()
    figure, axis = plt.subplots(figsize=(7.6, 2.9))
    for place, (arm, _) in enumerate(RUNGS):
        theirs, first = _paper(paper, f"static.{arm}.all"), place == 0
        if ours := _bar(axis, metrics, place - 0.2, arm, "all", DARK, "here" if first else None):
            axis.annotate(f"{ours[0]:.3f}", (place - 0.2, ours[1]), (0, 3), **ABOVE)
        axis.bar(place + 0.2, theirs, 0.36, color=PALE, label="paper" if first else None, zorder=2)
        axis.annotate(f"{theirs:.3f}", (place + 0.2, theirs), (0, 3), **ABOVE)
    axis.set_xticks(range(len(RUNGS)), [words for _, words in RUNGS])
    axis.legend(frameon=False, ncols=2, loc="upper left")
    _finished(plt, figure, axis, "success, static gate", output)


def memory(metrics: Metrics, paper: Paper, output: Path) -> None:
    """Static success by relation: bars with one visit and with two, ours with intervals; diamonds are the paper's."""
    plt = _pyplot()
    figure, axis = plt.subplots(figsize=(7.6, 3.1))
    for offset, arm, colour, words in ((-0.2, ONE, LIGHT, "one visit (expected)"), (0.2, TWO, DARK, "two visits")):
        for place, relation in enumerate(RELATIONS):
            theirs, first = _paper(paper, f"static.{arm}.{relation}"), place == 0
            label = "paper" if first and arm == TWO else None
            axis.plot(place + offset, theirs, color=INK, linestyle="", label=label, zorder=4, **DIAMOND)
            _bar(axis, metrics, place + offset, arm, relation, colour, words if first else None)
    axis.set_xticks(range(len(RELATIONS)), [relation.upper() for relation in RELATIONS])
    axis.legend(frameon=False, ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.16))
    _finished(plt, figure, axis, "success, static gate", output)


def _bar(
    axis: Any, metrics: Metrics, place: float, arm: str, relation: str, colour: str, label: str | None
) -> tuple[float, float] | None:
    """Draws a static rate of ours with its interval. The rate and the upper end; None, and nothing drawn, without metrics."""
    rate, low, high = (found(sources.static(arm, relation, column), metrics) for column in ("rate", "low", "high"))
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


def _finished(plt: Any, figure: Any, axis: Any, title: str, output: Path) -> None:
    axis.set_ylim(0, 1.09)
    axis.set_ylabel(title, color=INK)
    axis.grid(axis="y", color=PALE, linewidth=0.6)
    axis.set_axisbelow(True)
    axis.tick_params(colors=INK, length=0)
    for side in ("top", "right", "left"):
        axis.spines[side].set_visible(False)
    axis.spines["bottom"].set_color(PALE)
    figure.tight_layout(pad=0.5)
    figure.savefig(output, dpi=DPI, format="png", facecolor="white", metadata=PLAIN)
    plt.close(figure)
