"""The table of the error budget."""

from __future__ import annotations

from collections.abc import Sequence

from ovman.analysis.rates import ALL
from ovman.report.cells import Record, number, p_value, percent, signed, span
from ovman.report.table import DATA, PAGE, Column, Row, Table


def budget_table(steps: Sequence[Record], confidence: float) -> Table:
    """The rungs over all episodes. steps: rows of "budget.csv"; confidence: of the intervals."""
    return Table(
        name="budget",
        caption=(
            "Error budget of the two-visit agent, static gate: each rung hands over one source of error more. Gained, lost: "
            "episodes, against the line above; p: exact two-sided McNemar test on them. The answer given succeeds by definition. "
            f"Ranges are Wilson {percent(confidence)} intervals."
        ),
        columns=(
            Column("rung", "rung"),
            Column("arm", "arm", formats=DATA),
            Column("rate", "rate", numeric=True),
            Column("low", "low", numeric=True, formats=DATA),
            Column("high", "high", numeric=True, formats=DATA),
            Column("range", percent(confidence), formats=PAGE),
            Column("gain", "gain", numeric=True),
            Column("gained", "gained", numeric=True),
            Column("lost", "lost", numeric=True),
            Column("p", "p", numeric=True, formats=DATA),
            Column("p_page", "p", numeric=True, formats=PAGE),
            Column("n", "n", numeric=True),
        ),
        rows=tuple(
            Row(
                {
                    "rung": row["rung"],
                    "arm": row["arm"],
                    "rate": number(row["rate"]),
                    "low": number(row["low"]) if row["low"] else "",
                    "high": number(row["high"]) if row["high"] else "",
                    "range": span(row["low"], row["high"]),
                    "gain": signed(row["gain"]),
                    "gained": row["gained"],
                    "lost": row["lost"],
                    "p": row["p"],
                    "p_page": p_value(row["p"]),
                    "n": row["n"],
                }
            )
            for row in steps
            if row["relation"] == ALL
        ),
    )
