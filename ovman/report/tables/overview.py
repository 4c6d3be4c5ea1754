"""The table of who reaches what on which split."""

from __future__ import annotations

import pandas as pd

from ovman.report.tables.columns import numbers, three, words
from ovman.report.tables.table import CONTROLS, SECTION, Table
from ovman.settings import Kind, Settings

SHORT = {Kind.STATIC: "static", Kind.EMBODIED: "driving"}


def overview_table(rates: pd.DataFrame, settings: Settings) -> Table:
    """A row an entry of comparisons.overview, a column a split and kind, controls last. rates: rows of `Overview`."""
    judged = list(dict.fromkeys(zip(rates["split"], rates["kind"], strict=True)))
    titles = sorted(dict.fromkeys(rates["title"]), key=lambda title: bool(rates.loc[rates["title"] == title, "control"].all()))
    rows = []
    for title in titles:
        of = rates[rates["title"] == title]
        values = {f"{one.split}_{one.kind}": one.rate for one in of.itertuples()}
        rows.append({"system": title, **values, SECTION: CONTROLS if of["control"].all() else ""})
    columns = (words("system"), *(numbers(f"{split}_{kind}", f"{split}, {SHORT[Kind(kind)]}", three) for split, kind in judged))
    episodes = ", ".join(f"{n} of {split}" for split, n in rates.groupby("split", sort=False)["n"].first().items())
    caption = (
        f"Success over all relations, on the static gate (a point within {settings.success.radius_m} m of the answer) and "
        f"driving (at the stop, mean over the seeds); {episodes}. — means not evaluated. Controls lack something that the task "
        "is said to need. Published systems are reimplemented."
    )
    return Table(caption, columns, pd.DataFrame(rows, columns=[*(column.key for column in columns), SECTION]))
