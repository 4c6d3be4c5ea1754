"""The table of tests on every split."""

from __future__ import annotations

import pandas as pd

from ovman.analysis.significance import Method
from ovman.report.tables.columns import MARK, numbers, p_values, signed, words
from ovman.report.tables.controls import JUDGED
from ovman.report.tables.significance import OF_A_PICK, counts, test_column
from ovman.report.tables.table import DATA, SECTION, Table
from ovman.settings import Settings


def split_significance_table(comparisons: pd.DataFrame, settings: Settings) -> Table:
    """A row a pair and seed, by split. comparisons: rows of `SplitComparison`."""
    rows = comparisons.assign(
        judged=comparisons["kind"].map(JUDGED),
        comparison=comparisons["title"],
        gain=(comparisons["successes"] - comparisons["baseline_successes"]) / comparisons["n"],
    )
    rows[SECTION] = rows["split"] + ", " + rows["judged"]
    for key in ("baseline_successes", "wins", "losses"):
        rows[key] = counts(rows, key)
    columns = (
        words("split"),
        words("judged"),
        words("comparison"),
        words("arm", formats=DATA),
        words("baseline", formats=DATA),
        numbers("seed"),
        numbers("n"),
        numbers("successes"),
        numbers("baseline_successes", "baseline"),
        numbers("gain", data=signed),
        numbers("wins"),
        numbers("losses"),
        test_column(),
        p_values("p", "p"),
    )
    caption = (
        "Arm against arm on the same episodes of each split, over all relations, under each seed: a win is an episode on which "
        "the first succeeds and the second, the baseline, does not. Gain: of the success rate. McNemar: exact, two-sided, on "
        "wins and losses; not corrected."
    )
    if (comparisons["test"] == Method.POISSON_BINOMIAL).any():
        caption += f" {MARK} Against a stochastic pick: expectations. {OF_A_PICK}."
    return Table(caption, columns, rows.drop(columns=["kind", "title"]), wide=True)
