"""The table of stops that the success test accepts beside the target's box, though the predicted point fails."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import exact_mean, numbers, relation_column, three, words
from ovman.report.tables.table import Table
from ovman.settings import Settings


def rescued_table(counts: pd.DataFrame, settings: Settings) -> Table:
    """By arm and relation, means over the seeds. counts: rows of `Rescued`."""
    rows = []
    for (arm, relation), seeds in counts.groupby(["arm", "relation"], sort=False):
        rows.append(
            {
                "agent": settings.arms[str(arm)].system,
                "relation": relation,
                "n": seeds["n"].iloc[0],
                "gained": exact_mean(seeds["gained"]),
                "rescued": exact_mean(seeds["rescued"]),
                "rescued_least": seeds["rescued"].min(),
                "rescued_most": seeds["rescued"].max(),
                "nearest_m": seeds["nearest_m"].min(),
                "farthest_m": seeds["farthest_m"].max(),
            }
        )
    columns = (
        words("agent"),
        relation_column(),
        numbers("n"),
        numbers("gained", data="{:.1f}".format),
        numbers("rescued", data="{:.1f}".format),
        numbers("rescued_least", "least"),
        numbers("rescued_most", "most"),
        numbers("nearest_m", "nearest, m", three),
        numbers("farthest_m", "farthest, m", three),
    )
    caption = (
        "Predictions that fail on the static gate and succeed when executed (gained), and those of them that stop within "
        f"{settings.success.radius_m} m of the target's box (rescued): mean, least and most over the seeds, and how far from the "
        "answer the predicted points of the rescued lie."
    )
    return Table(caption, columns, pd.DataFrame(rows))
