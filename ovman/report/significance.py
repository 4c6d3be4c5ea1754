"""The table of tests: arm against arm on the same episodes."""

from __future__ import annotations

from collections.abc import Sequence

from ovman.analysis.rates import ALL
from ovman.analysis.significance import Method
from ovman.report.cells import MARK, Record, count, p_value, small_capitals
from ovman.report.table import CSV_AND_MARKDOWN, DATA, PAGE, Column, Row, Table

OF_A_PICK = "Poisson-binomial: exact, one-sided, the probability that the pick succeeds at least as often as the first arm did"
"""What captions say of the test against a stochastic pick."""
TESTS = {Method.MCNEMAR: "McNemar", Method.POISSON_BINOMIAL: f"Poisson-binomial{MARK}"}


def significance_table(comparisons: Sequence[Record]) -> Table:
    """Wins, losses and p of every pair, by relation and over all. comparisons: rows of "significance.csv".

    A pair that was run under several seeds is shown under the first; the caption has what the others come to.
    """
    first: dict[str, str] = {}
    for row in comparisons:
        first.setdefault(row["title"], row["seed"])
    shown = [row for row in comparisons if row["seed"] == first[row["title"]]]
    others = [row for row in comparisons if row["seed"] != first[row["title"]] and row["relation"] == ALL]
    return Table(
        name="significance",
        caption=_caption(shown, others),
        columns=(
            Column("comparison", "comparison", formats=CSV_AND_MARKDOWN),
            Column("arm", "arm", formats=DATA),
            Column("baseline", "baseline", formats=DATA),
            Column("seed", "seed", formats=DATA),
            Column("relation", "relation"),
            Column("n", "n", numeric=True),
            Column("successes", "successes", numeric=True),
            Column("baseline_successes", "baseline", numeric=True),
            Column("wins", "wins", numeric=True),
            Column("losses", "losses", numeric=True),
            Column("test", "test", formats=DATA),
            Column("test_page", "test", formats=PAGE),
            Column("p", "p", numeric=True, formats=DATA),
            Column("p_holm", "p Holm", numeric=True, formats=DATA),
            Column("p_page", "p", numeric=True, formats=PAGE),
            Column("p_holm_page", "p (Holm)", numeric=True, formats=PAGE),
        ),
        rows=tuple(_row(row) for row in shown),
        wide=True,
    )


def _row(row: Record) -> Row:
    method = Method(row["test"])
    expected = method is Method.POISSON_BINOMIAL
    return Row(
        {
            "comparison": row["title"],
            "arm": row["arm"],
            "baseline": row["baseline"],
            "seed": row["seed"],
            "relation": small_capitals(row["relation"]),
            "n": row["n"],
            "successes": row["successes"],
            "baseline_successes": count(row["baseline_successes"], expected),
            "wins": count(row["wins"], expected),
            "losses": count(row["losses"], expected),
            "test": method.value,
            "test_page": TESTS[method],
            "p": row["p"],
            "p_holm": row["p_holm"],
            "p_page": p_value(row["p"]),
            "p_holm_page": p_value(row["p_holm"]),
        },
        section=row["title"],
    )


def _caption(shown: Sequence[Record], others: Sequence[Record]) -> str:
    caption = (
        "Arm against arm on the same episodes: a win is an episode on which the first succeeds and the second, the baseline, "
        "does not. McNemar: exact, two-sided, on wins and losses. p (Holm): corrected for the relations of one comparison; all "
        "is one test and is not corrected."
    )
    stochastic = [row for row in shown if row["test"] == Method.POISSON_BINOMIAL]
    if stochastic:
        caption += f" {MARK} The baseline is a stochastic pick: its successes, wins and losses are expectations. {OF_A_PICK}."
    if any(float(row["p"]) == 0.0 for row in stochastic):
        caption += " 0: more successes than the pick can come to."
    for title in dict.fromkeys(row["title"] for row in others):
        seed = next(row["seed"] for row in shown if row["title"] == title)
        further = "; ".join(
            f"seed {row['seed']}: {count(row['wins'])} to {count(row['losses'])}, p = {_plain(row['p'])}"
            for row in others
            if row["title"] == title
        )
        caption += f" {title[0].upper()}{title[1:]}: shown for seed {seed}; over all, {further}."
    return caption


def _plain(text: str) -> str:
    words = p_value(text)
    return words if isinstance(words, str) else words.plain
