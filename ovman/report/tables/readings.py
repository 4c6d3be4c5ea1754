"""The table of what handing the grounding over means: success by each reading, beside own grounding and true positions."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import (
    ALL,
    RELATIONS,
    numbers,
    of_relation,
    p_values,
    percent,
    range_column,
    span,
    three,
    words,
)
from ovman.report.tables.table import DATA, SECTION, Table
from ovman.settings import Settings


def readings_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """A row an arm, by the map that it reads. rates: rows of `HandedOver`."""
    rows = [_row(of_arm) for _, of_arm in rates.groupby("arm", sort=False)]
    columns = (
        words("map", formats=DATA),
        words("grounding"),
        words("arm", formats=DATA),
        *(of_relation(relation, three) for relation in (*RELATIONS, ALL)),
        range_column(settings.evaluation.confidence),
        numbers("gained"),
        numbers("lost"),
        p_values("p", "p"),
    )
    caption = (
        "Oracle grounding by each reading, static gate: map objects most of whose detections show the category at an IoU of 0.5 "
        "(majority, as in all other tables), with one such detection (any), or nearest to the true positions, within the success "
        "radius (nearest). Gained, lost: episodes, against own grounding; p: exact McNemar test. Ranges are "
        f"{percent(settings.evaluation.confidence)} intervals."
    )
    return Table(caption, columns, pd.DataFrame(rows), wide=True)


def _row(of_arm: pd.DataFrame) -> dict[str, object]:
    whole = of_arm[of_arm["relation"] == ALL].iloc[0]
    row: dict[str, object] = {SECTION: whole["map"], **{key: whole[key] for key in ("map", "grounding", "arm")}}
    row |= {str(rate.relation): rate.rate for rate in of_arm.itertuples()}
    row["range"] = span(whole["low"], whole["high"])
    return row | {key: whole[key] for key in ("gained", "lost", "p") if pd.notna(whole["p"])}
