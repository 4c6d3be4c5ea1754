"""The two charts of the page: the error budget, and success by relation with two visits against one."""

from __future__ import annotations

from collections.abc import Sequence
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
RUNGS = ((TWO, "own perception"), (GROUNDING, "grounding\nhanded over"), (POSITIONS, "positions\nhanded over"))
DIAMOND = {"marker": "D", "markersize": 5, "markerfacecolor": "white"}
DPI = 150
# Which release of the library wrote it is no part of the picture.
PLAIN = {"Software": None}


def budget(metrics: Metrics, paper: Paper, output: Path) -> None:
    """Success of the two-visit agent with each source of error handed over, ours with intervals, the paper's beside it."""
    plt = _pyplot()
    figure, axis = plt.subplots(figsize=(6.4, 3.1))
    places = range(len(RUNGS))
    theirs = [_paper(paper, f"static.{arm}.all") for arm, _ in RUNGS]
    axis.plot(places, theirs, color=INK, linestyle=":", label="paper", zorder=2, **DIAMOND)
    _with_intervals(axis, metrics, [(place, arm) for place, (arm, _) in zip(places, RUNGS, strict=True)])
    axis.set_xticks(list(places), [words for _, words in RUNGS])
    axis.set_xlim(-0.4, len(RUNGS) - 0.6)
    axis.legend(frameon=False, loc="upper left")
    _finished(plt, figure, axis, "success, static gate", output)


def memory(metrics: Metrics, paper: Paper, output: Path) -> None:
    """Static success by relation: bars with one visit and with two, ours with intervals; diamonds are the paper's."""
    plt = _pyplot()
    figure, axis = plt.subplots(figsize=(7.6, 3.1))
    for offset, arm, colour, words in ((-0.2, ONE, LIGHT, "one visit (expected)"), (0.2, TWO, DARK, "two visits")):
        for place, relation in enumerate(RELATIONS):
            rate, low, high = (found(sources.static(arm, relation, column), metrics) for column in ("rate", "low", "high"))
            theirs, first = _paper(paper, f"static.{arm}.{relation}"), place == 0
            label = "paper" if first and arm == TWO else None
            axis.plot(place + offset, theirs, color=INK, linestyle="", label=label, zorder=4, **DIAMOND)
            if rate and low and high:
                reach = [[max(0.0, rate.value - low.value)], [max(0.0, high.value - rate.value)]]
                axis.bar(place + offset, rate.value, 0.36, color=colour, label=words if first else None, zorder=2)
                axis.errorbar(place + offset, rate.value, reach, color=INK, linewidth=0.8, capsize=2, zorder=3)
    axis.set_xticks(range(len(RELATIONS)), [relation.upper() for relation in RELATIONS])
    axis.legend(frameon=False, ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.16))
    _finished(plt, figure, axis, "success, static gate", output)


def _with_intervals(axis: Any, metrics: Metrics, placed: Sequence[tuple[int, str]]) -> None:
    drawn = []
    for place, arm in placed:
        rate, low, high = (found(sources.static(arm, column=column), metrics) for column in ("rate", "low", "high"))
        if rate and low and high:
            drawn.append((place, rate.value, rate.value - low.value, high.value - rate.value))
    if drawn:
        x, y, below, above = zip(*drawn, strict=True)
        reach = [[max(0.0, b) for b in below], [max(0.0, a) for a in above]]
        axis.errorbar(x, y, reach, color=DARK, marker="o", capsize=3, linewidth=1.8, label="here", zorder=3)
        for place, value, *_ in drawn:
            axis.annotate(f"{value:.3f}", (place, value), (8, -13), textcoords="offset points", color=DARK, fontsize=9)


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
    axis.set_ylim(0, 1.05)
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
