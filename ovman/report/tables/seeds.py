"""The table of how far apart the seeds of an arm lie."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import (
    ALL,
    ARM_COLUMNS,
    RELATIONS,
    arms_frame,
    exact_mean,
    extreme_columns,
    numbers,
    small_capitals,
    span,
    three,
    words,
)
from ovman.report.tables.table import DATA, PAGE, SECTION, Column, Table
from ovman.settings import Kind, Settings

SECTIONS = {Kind.STATIC: "static gate, by run", Kind.EMBODIED: "embodied, by seed"}


def seeds_table(passes: pd.DataFrame, settings: Settings) -> Table:
    """One row an arm. passes: rows of `Pass`."""
    rows = pd.DataFrame([_row(str(arm), of_arm) for arm, of_arm in passes.groupby("arm", sort=False)])
    columns = (
        words("arm", formats=DATA),
        *ARM_COLUMNS[:3],
        *(
            column
            for relation in RELATIONS
            for column in (
                *extreme_columns(relation),
                Column(relation, relation.upper(), title_tex=small_capitals(relation.upper()), formats=PAGE),
            )
        ),
        words("each", "each seed"),
        numbers("mean", data=three),
        *extreme_columns(ALL),
        numbers("spread", data=three),
        numbers("n"),
    )
    caption = (
        "Success under each seed, and for static arms that answer differently each time they run, in each run: the same "
        "episodes every time. Relations: from the least to the greatest of a seed. Spread: the greatest of all minus the "
        "least. All other static arms answer the same under every seed."
    )
    arms = arms_frame(settings)[[column.key for column in ARM_COLUMNS[:3]]]
    return Table(caption, columns, rows.join(arms, on="arm") if len(rows) else rows, wide=True)


def _row(arm: str, passes: pd.DataFrame) -> dict[str, object]:
    row: dict[str, object] = {SECTION: SECTIONS[Kind(passes["kind"].iloc[0])], "arm": arm}
    for relation, of_relation in passes.groupby("relation", sort=False):
        rates = of_relation["rate"]
        row |= {f"{relation}_min": rates.min(), f"{relation}_max": rates.max()}
        if relation == ALL:
            row |= {
                "each": ", ".join(map(three, rates)),
                "mean": exact_mean(rates),
                "spread": rates.max() - rates.min(),
                "n": of_relation["n"].iloc[0],
            }
        else:
            row[str(relation)] = span(rates.min(), rates.max())
    return row
