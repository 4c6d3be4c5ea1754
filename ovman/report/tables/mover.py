"""The table of the movers of MOVING episodes."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.mover import WALKS
from ovman.report.tables.columns import numbers, three, words
from ovman.report.tables.table import Table
from ovman.settings import Settings


def mover_table(rows: pd.DataFrame, settings: Settings) -> Table:
    """One row between the visits, then one for each number of agent actions. rows: of `MoverDistance`."""
    columns = (
        words("phase"),
        numbers("actions", "agent actions"),
        numbers("n"),
        numbers("least_m", "least (m)", three),
        numbers("median_m", "median (m)", three),
        numbers("greatest_m", "greatest (m)", three),
        numbers("within", "within R", three),
        numbers("moved", "also MOVED"),
    )
    radius_m = rows["radius_m"].iloc[0] if len(rows) else settings.success.radius_m
    caption = (
        "How far the movers of MOVING episodes go: from where they stood in visit 1 to where visit 2 ended, and from there, "
        f"{WALKS} walks of each with no agent in the way, after so many agent actions. "
        f"R is {radius_m:g} m; also MOVED: episodes whose target satisfies that relation, too."
    )
    return Table(caption, columns, rows.drop(columns="radius_m"))
