"""Arm against arm on every split: the same numbers as of the split's own test, for the pairs that are asked for."""

from __future__ import annotations

import pytest

from ovman.analysis import frames, split_significance
from ovman.analysis.controls import Judged
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.significance import Method
from ovman.analysis.split_significance import SplitComparison
from ovman.analysis.statistics import mcnemar_exact
from ovman.report.tables.split_significance import split_significance_table
from ovman.report.tables.table import markdown
from ovman.settings import Kind
from ovman.workflow.parameter import stage_settings
from tests.analysis.fabricated import embodied, static
from tests.arms import CONFIG

CONSTANTS = stage_settings(CONFIG, "controls")
PAIRS = [pair for pair in CONFIG.comparisons.pairs.values() if pair.every_split]
OF_KIND = {kind: [pair for pair in PAIRS if CONFIG.arms[pair.arm].kind is kind] for kind in Kind}
N = {"main": 12, "multi": 18}


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Outcomes of both splits on paper, and of main driving: of each pair the first wins what is even, the other each third."""
    directory = tmp_path_factory.mktemp("outcomes")

    def arms(kind):
        return list(dict.fromkeys(name for pair in OF_KIND[kind] for name in (pair.arm, pair.baseline)))

    first = {pair.arm for pair in PAIRS}
    for split, count in N.items():
        won = [static(arm, n, n % (2 if arm in first else 3) == 0) for arm in arms(Kind.STATIC) for n in range(count)]
        frames.write(directory / f"{'static' if split == 'main' else split}_outcomes.csv", StaticOutcome, won)
    driven = [
        embodied(arm, n, n % (2 if arm in first else 3) == 0, seed)
        for arm in arms(Kind.EMBODIED)
        for seed in (0, 1)
        for n in range(12)
    ]
    frames.write(directory / "embodied_outcomes.csv", EmbodiedOutcome, driven)
    files = [[directory / f"{name}_{what}.csv" for name in ("static", "embodied", "multi")] for what in ("rates", "outcomes")]
    split_significance.run(*files, CONSTANTS, directory / "split_significance.csv")
    return frames.read_rows(directory / "split_significance.csv", SplitComparison), directory / "split_significance.csv"


def test_every_pair_that_is_asked_for_is_tested_on_every_split_under_every_seed(rows):
    found, _ = rows
    seen = [(row.split, row.kind, row.title, row.seed) for row in found]
    wanted = [("main", Kind.STATIC, pair.name, 0) for pair in OF_KIND[Kind.STATIC]]
    wanted += [("main", Kind.EMBODIED, pair.name, seed) for pair in OF_KIND[Kind.EMBODIED] for seed in (0, 1)]
    wanted += [("multi", Kind.STATIC, pair.name, 0) for pair in OF_KIND[Kind.STATIC]]
    assert seen == wanted and OF_KIND[Kind.STATIC] and OF_KIND[Kind.EMBODIED]


def test_wins_losses_and_p_are_counted_by_hand(rows):
    first = {pair.arm for pair in PAIRS}
    for row in rows[0]:
        if row.baseline in first:  # wins what its opponent wins
            assert (row.wins, row.losses, row.p) == (0, 0, 1.0)
            continue
        won = [({n % 2 == 0}, {n % 3 == 0}) for n in range(N[row.split])]
        wins, losses = (won.count(({a}, {b})) for a, b in ((True, False), (False, True)))
        assert (row.wins, row.losses, row.n) == (wins, losses, N[row.split])
        assert row.p == pytest.approx(mcnemar_exact(wins, losses), abs=1e-6)


def test_a_row_says_which_arm_was_tested_against_which(tmp_path):
    pair = OF_KIND[Kind.STATIC][0]
    won = [static(pair.arm, n, n < 3) for n in range(4)] + [static(pair.baseline, n, n == 3) for n in range(4)]
    frames.write(tmp_path / "static_outcomes.csv", StaticOutcome, won)
    judged = Judged("main", Kind.STATIC, tmp_path / "static_rates.csv", tmp_path / "static_outcomes.csv")
    assert split_significance.compared(judged, CONSTANTS) == [
        SplitComparison(
            "main", Kind.STATIC, pair.name, pair.arm, pair.baseline, 0, 4, 3, 1.0, 3.0, 1.0, Method.MCNEMAR, mcnemar_exact(3, 1)
        )
    ]


def test_the_table_has_a_block_a_split_and_is_there_without_rows(rows):
    page = markdown(split_significance_table(frames.read(rows[1], SplitComparison), CONFIG))
    assert page.count("| main ") and page.count("| multi ") and "nan" not in page
    assert len(split_significance_table(frames.frame_of(SplitComparison, []), CONFIG).rows) == 0
