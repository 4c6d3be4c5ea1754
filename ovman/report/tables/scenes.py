"""The table of success scene by scene, every arm."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import ARM_COLUMNS, arms_frame, numbers, three, words
from ovman.report.tables.table import DATA, SECTION, Table
from ovman.settings import Kind, Settings

SECTIONS = {Kind.STATIC: "static gate", Kind.EMBODIED: "embodied"}


def scenes_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """One row an arm: its worst and its best scene; the csv has every scene. rates: rows of `SceneRate`."""
    names = rates["scene"].unique().tolist()
    rows = pd.DataFrame([_row(str(arm), of_arm) for arm, of_arm in rates.groupby("arm", sort=False)])
    columns = (
        words("arm", formats=DATA),
        *ARM_COLUMNS,
        words("worst", "worst scene"),
        numbers("worst_n", "n"),
        numbers("worst_rate", "rate", three),
        words("best", "best scene"),
        numbers("best_n", "n"),
        numbers("best_rate", "rate", three),
        numbers("never", "scenes without success"),
        numbers("scenes"),
        *(numbers(name, name, three, DATA) for name in names),
    )
    caption = (
        "Success scene by scene, means over seeds or runs: of each arm the scene with the least and the one with the "
        "greatest rate, of equal ones the first, with its number of episodes, and in how many scenes the arm never succeeds. "
        + (f"A scene has {rates['n'].min()} to {rates['n'].max()} episodes: " if names else "")
        + "read the intervals of the metrics. The csv has every scene."
    )
    return Table(caption, columns, rows.join(arms_frame(settings), on="arm") if names else rows, wide=True)


def _row(arm: str, scenes: pd.DataFrame) -> dict[str, object]:
    # Of equal scenes the first.
    worst, best = (scenes.iloc[int(place)] for place in (scenes["rate"].argmin(), scenes["rate"].argmax()))
    return {
        SECTION: SECTIONS[Kind(scenes["kind"].iloc[0])],
        "arm": arm,
        "worst": worst["scene"],
        "worst_n": worst["n"],
        "worst_rate": worst["rate"],
        "best": best["scene"],
        "best_n": best["n"],
        "best_rate": best["rate"],
        "never": (scenes["rate"] == 0.0).sum(),
        "scenes": len(scenes),
        **dict(zip(scenes["scene"], scenes["rate"], strict=True)),
    }
