"""The table of what executing answers costs."""

from __future__ import annotations

from collections.abc import Sequence

from ovman.analysis.rates import ALL
from ovman.models.settings import Arm, named
from ovman.report.cells import MARK, Record, grouped, spread_cells, spread_columns
from ovman.report.table import DATA, PAGE, Column, Row, Table

SCORES = {"sr": "SR", "spl": "SPL", "spl_given_success": "SPL given success"}


def navigation_table(navigations: Sequence[Record], arms: Sequence[Arm]) -> Table:
    """One row an embodied arm, over all episodes: means and extremes over the seeds. navigations: rows of "navigation.csv"."""
    of_arm = grouped((row for row in navigations if row["relation"] == ALL), "arm")
    return Table(
        name="navigation",
        caption=(
            "What executing an answer costs. SR, SPL and SPL given success (the mean over successful runs): means over seeds, in "
            "brackets the least and the greatest of a seed. Lost: static successes that fail when executed; gained: static "
            "failures that succeed, as the stop test also accepts a stop near the target's box or the nearest navigable cell; "
            "counts of each seed in turn. Static: success of the answers that are executed "
            f"({MARK} expectation of a stochastic pick, which has no successes to lose)."
        ),
        columns=(
            Column("agent", "agent"),
            Column("static", "static", numeric=True, formats=DATA),
            Column("static_page", "static", numeric=True, formats=PAGE),
            *(column for key, title in SCORES.items() for column in spread_columns(key, title)),
            Column("lost", "lost"),
            Column("gained", "gained"),
            Column("n", "n", numeric=True),
            Column("seeds", "seeds"),
        ),
        rows=tuple(_row(named(arms, arm), rows) for (arm,), rows in of_arm.items()),
        wide=True,
    )


def _row(arm: Arm, rows: Sequence[Record]) -> Row:
    cells = {
        "agent": arm.system,
        "n": rows[0]["n"],
        "seeds": ", ".join(row["seed"] for row in rows),
        "lost": ", ".join(row["lost"] for row in rows if row["lost"]),
        "gained": ", ".join(row["gained"] for row in rows if row["gained"]),
    }
    if rows[0]["static_successes"]:
        mark = "" if rows[0]["lost"] else MARK
        rate = f"{float(rows[0]['static_successes']) / int(rows[0]['n']):.3f}"
        cells |= {"static": rate, "static_page": rate + mark}
    for key in SCORES:
        values = [float(row[key]) for row in rows if row[key]]
        if values:
            cells |= spread_cells(key, values)
    return Row(cells)
