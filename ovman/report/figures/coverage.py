"""Success by coverage: what an agent reaches if it answers only where it is surest, a line a split."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ovman.report.figures.canvas import AMBER, COLUMN_IN, DARK, INK, SMALL_PT, absent, drawing, framed
from ovman.report.paper_comparison.metrics import Metrics, Missing
from ovman.settings import Settings

HEIGHT_IN = 2.2
_LINES = ((DARK, "-"), (AMBER, "-"), (INK, "--"), (DARK, ":"), (AMBER, ":"))
"""Of splits and agents, in turn."""


def draw(metrics: Metrics, settings: Settings, output: Path) -> None:
    """Write a line and its interval for every split and agent of metrics `coverage`."""
    try:
        rows, missing = metrics.frame("coverage"), ""
    except Missing as error:
        rows, missing = pd.DataFrame(columns=["split", "arm"]), str(error)
    with drawing(output) as plt:
        figure, axis = plt.subplots(figsize=(COLUMN_IN, HEIGHT_IN), layout="constrained")
        for number, ((split, arm), line) in enumerate(rows.groupby(["split", "arm"], sort=False)):
            colour, dashes = _LINES[number % len(_LINES)]
            at, rate, low, high = (line[column].astype(float).to_numpy() for column in ("coverage", "rate", "low", "high"))
            axis.plot(
                at, rate, color=colour, linestyle=dashes, linewidth=1.2, label=f"{settings.arms[str(arm)].system}, split {split}"
            )
            axis.fill_between(at, low, high, color=colour, alpha=0.12, linewidth=0)
        if len(rows):
            axis.legend(frameon=False, fontsize=SMALL_PT, loc="lower left")
        else:
            absent(axis, missing)
        framed(axis, "success among the answers")
        axis.set_xlim(0, 1)
        axis.set_xticks([0.2, 0.4, 0.6, 0.8, 1.0])
        axis.set_xlabel("coverage (share of episodes answered, surest first)")
