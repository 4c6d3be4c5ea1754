"""The table of what recognising the category alone is worth."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import ALL, ARM_COLUMNS, arms_frame, numbers, relation_column, signed, three, words
from ovman.report.tables.table import DATA, SECTION, Table
from ovman.settings import Settings

SHORTCUTS, OTHERS = "any instance of the category", "all arms"


def shortcuts_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """The arms of comparisons.shortcuts by relation, then every arm over all of them. rates: rows of `Shortcut`."""
    titles = settings.comparisons.shortcuts
    picks = pd.concat([rates[rates["arm"] == arm] for arm in titles] or [rates.iloc[:0]])
    rows = pd.concat([picks, rates[rates["relation"] == ALL]])
    rows[SECTION] = [f"{SHORTCUTS}, {titles[arm]}" for arm in picks["arm"]] + [OTHERS] * (len(rows) - len(picks))
    rows = rows.join(arms_frame(settings), on="arm")
    left = int(rates.loc[rates["relation"] == ALL, "crowded"].max()) if len(rates) else 0
    columns = (
        words("kind", formats=DATA),
        words("arm", formats=DATA),
        *ARM_COLUMNS,
        relation_column(),
        numbers("n"),
        numbers("chance", "1/n", three),
        numbers("rate", "success", three),
        numbers("excess", "over 1/n", signed),
        numbers("crowded"),
        numbers("crowded_rate", "crowded: success", _rate),
        numbers("uncrowded_rate", "others: success", _rate),
    )
    caption = (
        "The anti-shortcut rule: success and the mean of 1/n, n the instances of the category. The first arms pick an instance "
        "of the category at random, at its true position. Crowded: episodes with another instance within "
        f"{settings.success.radius_m} m of the answer, in the visit that the answer belongs to or in the second; "
        + ("success on them and on the others stands apart." if left else "no such episode is left.")
    )
    return Table(caption, columns, rows.reset_index(drop=True), wide=True)


def _rate(value: float) -> str:
    return "" if pd.isna(value) else three(value)
