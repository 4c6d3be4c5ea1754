"""The table of the margin of memory by the values of each threshold of admissibility."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from ovman.report.tables.columns import numbers as column
from ovman.report.tables.columns import signed, words
from ovman.report.tables.table import Table
from ovman.settings import Settings
from ovman.settings.sensitivity import THRESHOLDS

IN_FORCE, ALL = "in force", "all settings"
TITLES = {
    "drift_tolerance_m": "allowed drift, m",
    "tau_m": "counts as moved from, m",
    "delta_min_m": "least applied displacement, m",
    "min_mask_px": "smallest recorded mask, px",
    "motion_m": "least motion, m",
    "validity_radius_m": "answer to free floor, m",
    "spawn_clearance_m": "start to change, m",
    "visible_px": "smallest visible mask, px",
}
"""What pages call the thresholds."""


def sensitivity_table(margins: pd.DataFrame, settings: Settings) -> Table:
    """The setting in force, the range over all others, and the range over those with each value. margins: rows of `Margin`."""
    memory = settings.comparisons.memory
    columns = (
        words("threshold"),
        words("value"),
        column("settings"),
        column("episodes_least", "trials, least"),
        column("episodes_most", "most"),
        column("margin_least", "margin, least", signed),
        column("margin_greatest", "greatest", signed),
        column("released_least", "released, least"),
        column("released_margin_least", "margin, least", signed),
        column("released_margin_greatest", "greatest", signed),
    )
    arm, baseline = (settings.arms[name] for name in (memory.arm, memory.baseline))
    caption = (
        f"Static margin of memory ({arm.memory} less {baseline.memory}, {arm.system}) under other thresholds of admissibility, "
        "of which every combination is a setting. The predictions stay the same. Margins: least and greatest of the settings "
        "with a value, over all trials that a setting admits (certified or not), and over the released episodes that it leaves."
    )
    return Table(caption, columns, pd.DataFrame(list(_rows(margins))), wide=True)


def _rows(margins: pd.DataFrame) -> Iterator[dict[str, object]]:
    in_force, others = margins[margins["in_force"] == 1], margins[margins["in_force"] == 0]
    for threshold, group in ((IN_FORCE, in_force), (ALL, others)):
        if len(group):
            yield {"threshold": threshold, "value": "", **_range(group)}
    for name in THRESHOLDS:
        for value, group in others.groupby(name, sort=True):
            yield {"threshold": TITLES[name], "value": f"{value:g}", **_range(group)}


def _range(group: pd.DataFrame) -> dict[str, object]:
    return {
        "settings": len(group),
        "episodes_least": group["episodes"].min(),
        "episodes_most": group["episodes"].max(),
        "margin_least": group["margin"].min(),
        "margin_greatest": group["margin"].max(),
        "released_least": group["released"].min(),
        "released_margin_least": group["released_margin"].min(),
        "released_margin_greatest": group["released_margin"].max(),
    }
