"""Section "Controls" of the page: their success by relation, and what each of them means."""

from __future__ import annotations

from ovman.analysis.controls import Controlled
from ovman.analysis.frames import typed
from ovman.report.paper_comparison.metrics import Metrics, Missing
from ovman.report.tables.controls import controls_table
from ovman.report.tables.table import markdown_body
from ovman.settings import Settings


def controls_of(metrics: Metrics, settings: Settings) -> str:
    """The table of controls, Markdown. settings: arms, comparisons.controls, evaluation.confidence."""
    try:
        return markdown_body(controls_table(typed(metrics.frame("controls"), Controlled), settings))
    except Missing as missing:
        return f"Nothing can be told: {missing}.\n"


def meanings(settings: Settings) -> list[str]:
    """A line for each control that is an arm: its title, and what the settings say it means."""
    shown = ((settings.arms[name], entry.means) for name, entry in settings.comparisons.controls.items() if name in settings.arms)
    return [f"**{arm.system}** ({arm.kind}). {means}" for arm, means in shown if means]
