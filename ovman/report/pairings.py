"""The table of arms with several runs against each other."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ovman.analysis.significance import Method
from ovman.report.cells import MARK, Record, count, grouped, p_value, signed, small_capitals
from ovman.report.significance import OF_A_PICK, TESTS
from ovman.report.table import CSV_AND_MARKDOWN, DATA, PAGE, Column, Row, Table


def pairings_table(pairings: Sequence[Record]) -> Table:
    """One row a pair of arms and relation: mean, worst and best over the pairings. pairings: rows of "pairings.csv"."""
    groups = grouped(pairings, "title", "relation")
    return Table(
        name="pairings",
        caption=_caption(pairings),
        columns=(
            Column("comparison", "comparison", formats=CSV_AND_MARKDOWN),
            Column("arm", "arm", formats=DATA),
            Column("baseline", "baseline", formats=DATA),
            Column("relation", "relation"),
            Column("pairings", "pairings", numeric=True),
            Column("difference", "difference", numeric=True),
            Column("worst", "worst", numeric=True),
            Column("worst_runs", "worst runs", formats=DATA),
            Column("worst_wins", "wins", numeric=True),
            Column("worst_losses", "losses", numeric=True),
            Column("worst_p", "p of the worst", numeric=True, formats=DATA),
            Column("worst_p_page", "p", numeric=True, formats=PAGE),
            Column("best", "best", numeric=True),
            Column("best_runs", "best runs", formats=DATA),
            Column("best_p", "p of the best", numeric=True, formats=DATA),
            Column("best_p_page", "p", numeric=True, formats=PAGE),
            Column("test", "test", formats=DATA),
            Column("test_page", "test", formats=PAGE),
            Column("n", "n", numeric=True),
        ),
        rows=tuple(_row(title, relation, rows) for (title, relation), rows in groups.items()),
        wide=True,
    )


def _row(title: str, relation: str, rows: Sequence[Record]) -> Row:
    # Of equal differences the one that is harder on the claim: the larger p.
    worst = min(rows, key=lambda row: (float(row["difference"]), -float(row["p"])))
    best = max(rows, key=lambda row: (float(row["difference"]), -float(row["p"])))
    method = Method(worst["test"])
    expected = method is Method.POISSON_BINOMIAL
    return Row(
        {
            "comparison": title,
            "arm": rows[0]["arm"],
            "baseline": rows[0]["baseline"],
            "relation": small_capitals(relation),
            "pairings": str(len(rows)),
            "difference": signed(str(math.fsum(float(row["difference"]) for row in rows) / len(rows))),
            "worst": signed(worst["difference"]),
            "worst_runs": _runs(worst),
            "worst_wins": count(worst["wins"], expected),
            "worst_losses": count(worst["losses"], expected),
            "worst_p": worst["p"],
            "worst_p_page": p_value(worst["p"]),
            "best": signed(best["difference"]),
            "best_runs": _runs(best),
            "best_p": best["p"],
            "best_p_page": p_value(best["p"]),
            "test": method.value,
            "test_page": TESTS[method],
            "n": rows[0]["n"],
        },
        section=title,
    )


def _runs(row: Record) -> str:
    return f"{row['arm_run']}-{row['baseline_run']}"


def _caption(pairings: Sequence[Record]) -> str:
    caption = (
        "Static arms of which one has several runs, each run of the first against each run of the second, the baseline. "
        "Difference: of the success rates, the mean over the pairings; worst and best: the pairing with the least and with the "
        "greatest. Wins, losses: of the worst pairing. p: of the pairing to its left, not corrected; McNemar: exact, two-sided."
    )
    if any(row["test"] == Method.POISSON_BINOMIAL for row in pairings):
        caption += f" {MARK} The baseline is a stochastic pick: wins and losses are expectations. {OF_A_PICK}" + (
            "; 0: more often than the pick can." if any(float(row["p"]) == 0.0 for row in pairings) else "."
        )
    return caption
