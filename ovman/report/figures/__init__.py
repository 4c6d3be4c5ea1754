"""Draw the figures: PNG for pages, PDF for print, at the width at which they are printed.

A chart is one function `draw(metrics, settings, output)` and one line of CHARTS.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from ovman.settings import Settings

CHARTS = {
    "agent": "ovman.report.figures.agent:draw_agent",
    "budget": "ovman.report.figures.sweeps:draw_budget",
    "controls": "ovman.report.figures.rates:draw_controls",
    "coverage": "ovman.report.figures.rates:draw_coverage",
    "difficulty": "ovman.report.figures.rates:draw_difficulty",
    "memory": "ovman.report.figures.rates:draw_memory",
    "rungs": "ovman.report.figures.rates:draw_rungs",
    "sensitivity": "ovman.report.figures.sweeps:draw_sensitivity",
}
"""Functions by the names of the files. They are imported when they draw: the workflow reads the names at every start."""


def draw_charts(metric_files: Sequence[Path], settings: Settings, directory: Path) -> None:
    """Write every chart into a directory as .png and .pdf; a chart says what it lacks. Equal files give equal bytes.

    Settings: arms, comparisons.agent, comparisons.difficulty, comparisons.controls, paper.
    """
    from ovman.report.figures.canvas import draw_missing
    from ovman.report.metrics import Metrics, Missing, name_arms

    metrics = Metrics.load(metric_files, name_arms(settings.comparisons, settings.paper))
    for name, place in CHARTS.items():
        module, _, function = place.partition(":")
        try:
            getattr(import_module(module), function)(metrics, settings, directory / f"{name}.png")
        except Missing as missing:
            draw_missing(str(missing), directory / f"{name}.png")
