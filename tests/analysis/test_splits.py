"""Metrics across splits: coverage, and the overview in the README."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.rates import arm_rates
from ovman.analysis.rows import write_csv
from ovman.analysis.splits import RANKS, STEPS, SplitResults, ranks, rate_by_coverage
from ovman.analysis.statistics import wilson_interval
from ovman.report.tables import TABLES, make_table, read_metrics
from ovman.settings import Kind
from tests.analysis.fabricated import named, static
from tests.arms import CONFIG
from tests.episodes import DATA

ROOT = Path(__file__).parents[2]


def outcomes_of(sure):
    return [replace(static("arm", n, success), confidence=confidence) for n, (confidence, success) in enumerate(sure)]


@settings(max_examples=20, derandomize=True, deadline=None)
@given(st.lists(st.tuples(st.floats(0, 1), st.booleans()), min_size=1, max_size=60))
def test_each_step_adds_less_sure_answers_and_the_last_has_all(sure):
    rows = named(rate_by_coverage(outcomes_of(sure), 0.95))
    assert [row.coverage for row in rows] == [step / STEPS for step in range(1, STEPS + 1)]
    assert [row.answered for row in rows] == sorted(row.answered for row in rows) and rows[-1].answered == len(sure)
    lowest = [row.least_confidence for row in rows]
    assert lowest == sorted(lowest, reverse=True) and lowest[-1] == min(confidence for confidence, _ in sure)
    assert rows[-1].successes == sum(success for _, success in sure)


def test_an_answer_without_a_confidence_is_the_least_sure():
    rows = named(rate_by_coverage(outcomes_of([(None, True), (0.25, False)]), 0.5))
    assert (rows[0].answered, rows[0].least_confidence, rows[0].successes) == (1, 0.25, 0)
    assert (rows[-1].least_confidence, rows[-1].rate) == (0.0, 0.5)
    assert (rows[-1].low, rows[-1].high) == wilson_interval(1, 2, 0.5)


def test_the_readme_shows_rates_of_the_release():
    """Compare each row of its table, by the beginning of the title. The last column is the mean on the leaderboard."""
    table = (
        make_table(TABLES["overview"], read_metrics(DATA / "metrics" / "overview.csv"), CONFIG).cells("csv").set_index("system")
    )
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    page = (ROOT / "leaderboard" / "README.md").read_text(encoding="utf-8").partition("## Public splits")[0]
    drawn = dict(re.findall(r"^\|(?: \d\.)? \[([^|]+)\]\([^|]+\|(?: +[\d.]+ \|){3} ([\d.]+) \|", page, re.MULTILINE))
    lines = re.findall(r"^\| ([^|]+?) *\|((?: +[\d.—]+ \|){5})$", text, re.MULTILINE)
    columns = [f"{split}_{kind}" for split in ("main", "everyday") for kind in ("static", "embodied")]
    assert len(lines) == 8 and drawn
    for title, cells in lines:
        system = re.split(", a control|:", title)[0]
        found = [*table.loc[system][columns], drawn.get(system)]
        assert cells.replace("|", " ").split() == [value or "—" for value in found], title


def results_of(split: str, rates: dict[str, list[float]]) -> SplitResults:
    """Make outcomes of static arms: one episode per scene, with these successes."""
    outcomes = [
        replace(static(arm, n, bool(success)), scene=f"FloorPlan{n}")
        for arm, successes in rates.items()
        for n, success in enumerate(successes)
    ]
    return SplitResults(split, Kind.STATIC, arm_rates(outcomes, 0.95), outcomes)


SYSTEMS = ("single_visit", "two_visits", "joint", "react_two_visits")


@settings(max_examples=5, derandomize=True, deadline=None)
@given(st.permutations(range(4)), st.permutations(range(4)))
def test_tau_counts_the_pairs_of_systems_that_both_splits_order_alike(first, second):
    def rank(split: str, order: list[int]) -> SplitResults:
        return results_of(split, {arm: [1] * (2 + place) + [0] * (6 - place) for arm, place in zip(SYSTEMS, order, strict=True)})

    given_ranks = CONFIG.with_values({"comparisons.ranks": {"main": "everyday"}})
    (row,) = named(ranks([rank("main", first), rank("everyday", second)], given_ranks))
    alike = [(a - b) * (c - d) > 0 for (a, c), (b, d) in combinations(zip(first, second, strict=True), 2)]
    assert row.systems == 4 and row.tau == pytest.approx((2 * sum(alike) - 6) / 6)
    assert -1 <= row.low <= row.high <= 1


def test_controls_ablations_oracles_and_missing_splits_have_no_rank():
    drawn = dict.fromkeys((*SYSTEMS, "category_only", "joint_without_depth", "grounding_two_visits"), [1, 0, 1, 0])
    drawn["joint"] = [1, 1, 1, 1]
    both = [results_of(split, drawn) for split in ("main", "everyday")]
    (row,) = named(ranks(both, CONFIG))
    assert (row.split, row.other, row.systems, row.tau) == ("main", "everyday", 4, pytest.approx(1.0))
    assert ranks(both[:1], CONFIG) == []
    few = [results_of(split, {"joint": [1, 0], "two_visits": [0, 0]}) for split in ("main", "everyday")]
    assert ranks(few, CONFIG) == []


def test_equal_systems_have_no_rank_and_the_table_says_so(tmp_path):
    both = [results_of(split, dict.fromkeys(SYSTEMS, [1, 1])) for split in ("main", "everyday")]
    rows = ranks(both, CONFIG)
    write_csv(tmp_path / "ranks.csv", RANKS, rows)
    assert "nan" not in (tmp_path / "ranks.csv").read_text()
    cells = make_table(TABLES["ranks"], read_metrics(tmp_path / "ranks.csv"), CONFIG).cells("md")
    assert cells.iloc[0, -2:].tolist() == ["—", "—"]
