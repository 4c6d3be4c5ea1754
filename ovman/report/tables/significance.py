"""The tables of tests: arm against arm on the same episodes, and run against run."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.significance import Method
from ovman.report.tables.columns import (
    ALL,
    MARK,
    count,
    exact_mean,
    numbers,
    p_values,
    relation_column,
    signed,
    words,
)
from ovman.report.tables.table import CSV_AND_MARKDOWN, DATA, SECTION, Column, Table
from ovman.settings import Settings

OF_A_PICK = "Poisson-binomial: exact, one-sided, that the pick does as well as the first arm"
"""What captions say of the test against a stochastic pick."""
TESTS = {Method.MCNEMAR: "McNemar", Method.POISSON_BINOMIAL: f"Poisson-binomial{MARK}"}


def significance_table(comparisons: pd.DataFrame, settings: Settings) -> Table:
    """Wins, losses and p of every pair, by relation and over all. comparisons: rows of `Comparison`.

    A pair that was run under several seeds has all relations under the first, and a row over all under each other seed.
    """
    first = comparisons.groupby("title", sort=False)["seed"].transform("first") if len(comparisons) else comparisons["seed"]
    shown = comparisons[(comparisons["seed"] == first) | (comparisons["relation"] == ALL)]
    rows = shown.rename(columns={"title": "comparison"}).assign(**{SECTION: shown["title"]})
    for key in ("baseline_successes", "wins", "losses"):
        rows[key] = counts(rows, key)
    columns = (
        words("comparison", formats=CSV_AND_MARKDOWN),
        words("arm", formats=DATA),
        words("baseline", formats=DATA),
        numbers("seed"),
        relation_column(),
        numbers("n"),
        numbers("successes"),
        numbers("baseline_successes", "baseline"),
        numbers("wins"),
        numbers("losses"),
        test_column(),
        p_values("p", "p"),
        p_values("p_holm", "p (Holm)"),
    )
    return Table(_caption(shown), columns, rows, wide=True)


def _caption(shown: pd.DataFrame) -> str:
    caption = (
        "Arm against arm on the same episodes: in a win the first alone succeeds, in a loss the second, the baseline. McNemar: "
        "exact, two-sided. p (Holm): corrected for the relations of one comparison."
    )
    stochastic = shown[shown["test"] == Method.POISSON_BINOMIAL]
    if len(stochastic):
        caption += f" {MARK} Against a stochastic pick: expectations. {OF_A_PICK}."
    if (stochastic["p"] == 0.0).any():
        caption += " p = 0: the pick cannot reach that."
    return caption


def pairings_table(pairings: pd.DataFrame, settings: Settings) -> Table:
    """One row a pair of arms and relation: mean, worst and best over the pairings. pairings: rows of `Pairing`."""
    groups = pairings.groupby(["title", "relation"], sort=False)
    rows = [_row(str(title), str(relation), runs) for (title, relation), runs in groups]
    columns = (
        words("comparison", formats=CSV_AND_MARKDOWN),
        words("arm", formats=DATA),
        words("baseline", formats=DATA),
        relation_column(),
        numbers("pairings"),
        numbers("difference", data=signed),
        numbers("worst", data=signed),
        words("worst_runs", "worst runs", formats=DATA),
        numbers("worst_wins", "wins"),
        numbers("worst_losses", "losses"),
        p_values("worst_p", "p"),
        numbers("best", data=signed),
        words("best_runs", "best runs", formats=DATA),
        p_values("best_p", "p"),
        test_column(),
        numbers("n"),
    )
    caption = (
        "Each run of an arm against each run of its baseline. Difference: of the success rates, mean over the pairings; worst, "
        "best: the least and the greatest. Wins, losses: of the worst. p: of the pairing to its left, not corrected; McNemar: "
        "exact, two-sided."
    )
    if (pairings["test"] == Method.POISSON_BINOMIAL).any():
        caption += f" {MARK} Against a stochastic pick: expectations. {OF_A_PICK}"
        caption += "; 0: it cannot." if (pairings["p"] == 0.0).any() else "."
    return Table(caption, columns, pd.DataFrame(rows), wide=True)


def _row(title: str, relation: str, runs: pd.DataFrame) -> dict[str, object]:
    # Of equal differences the worst is the one with the larger p, the best the one with the smaller p.
    ranked = runs.sort_values(["difference", "p"], ascending=[True, False], kind="stable")
    worst = ranked.iloc[0]
    best = ranked[ranked["difference"] == ranked["difference"].max()].sort_values("p", kind="stable").iloc[0]
    return {
        SECTION: title,
        "comparison": title,
        "arm": worst["arm"],
        "baseline": worst["baseline"],
        "relation": relation,
        "pairings": len(runs),
        "difference": exact_mean(runs["difference"]),
        "worst": worst["difference"],
        "worst_runs": f"{worst['arm_run']}-{worst['baseline_run']}",
        "worst_wins": count(worst["wins"], worst["test"] == Method.POISSON_BINOMIAL),
        "worst_losses": count(worst["losses"], worst["test"] == Method.POISSON_BINOMIAL),
        "worst_p": worst["p"],
        "best": best["difference"],
        "best_runs": f"{best['arm_run']}-{best['baseline_run']}",
        "best_p": best["p"],
        "test": worst["test"],
        "n": runs["n"].iloc[0],
    }


def counts(rows: pd.DataFrame, key: str) -> list[str]:
    """A column of counts, or of expectations where the baseline is a stochastic pick, as they are written."""
    return [count(value, test == Method.POISSON_BINOMIAL) for value, test in zip(rows[key], rows["test"], strict=True)]


def test_column() -> Column:
    """The column that names the test."""
    return Column("test", "test", page=lambda test: TESTS[Method(test)])
