"""Metrics across splits: controls and chance, the overview, coverage, and arm against arm."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.rates import arm_rates
from ovman.analysis.splits import (
    STEPS,
    SplitResults,
    controls,
    coverage,
    overview,
    rate_by_coverage,
    write_across_splits,
)
from ovman.analysis.statistics import wilson_interval
from ovman.report.tables import TABLES, make_table, read_metrics
from ovman.settings import Kind
from tests.analysis.fabricated import embodied, named, static
from tests.arms import ARMS, CONFIG
from tests.episodes import DATA

ROOT = Path(__file__).parents[2]
SETTINGS = CONFIG
SURE = next(arm.name for arm in ARMS if arm.kind is Kind.STATIC and any(other.ablates == arm.name for other in ARMS))
"""An agent of which there are ablations; they and its controls say how sure they are, too."""


def results(split, kind, outcomes):
    return SplitResults(split, kind, arm_rates(outcomes, 0.95), outcomes)


def test_controls_are_rates_of_the_split_in_the_order_of_the_settings_next_to_both_chances():
    shown = [name for name in CONFIG.comparisons.controls if CONFIG.arms[name].kind is Kind.STATIC]
    outcomes = [
        static(arm, n, n % 3 == 0, instances=2 + n % 3, alike=1 + n % 4) for arm in ["stranger", *shown] for n in range(12)
    ]
    one = results("main", Kind.STATIC, outcomes)
    rows = named(controls([one], SETTINGS))
    assert list(dict.fromkeys(row.arm for row in rows)) == shown
    rates = {(rate.arm, rate.relation): rate for rate in one.rates}
    for row in rows:
        rate, numbers = rates[row.arm, row.relation], [n for n in range(12) if row.relation in ("all", outcomes[n].relation)]
        assert (row.rate, row.low, row.high, row.n) == (rate.rate, rate.low, rate.high, len(numbers))
        assert row.chance == pytest.approx(sum(1 / (2 + n % 3) for n in numbers) / len(numbers))
        assert row.chance_of_change == pytest.approx(sum(1 / (1 + n % 4) for n in numbers) / len(numbers))
        assert row.control is CONFIG.arms[row.arm].control


def test_an_entry_of_the_overview_has_the_rate_of_its_arm_of_each_kind():
    title, entry = next((t, e) for t, e in CONFIG.comparisons.overview.items() if e.static and e.embodied)
    both = [
        results("main", Kind.STATIC, [static(entry.static, n, n < 3) for n in range(4)]),
        results("main", Kind.EMBODIED, [embodied(entry.embodied, n, n < 2, spl=0.5) for n in range(4)]),
    ]
    rows = [row for row in named(overview(both, SETTINGS)) if row.title == title]
    assert [(row.kind, row.arm, row.n, row.rate, row.spl) for row in rows] == [
        (Kind.STATIC, entry.static, 4, 0.75, None),
        (Kind.EMBODIED, entry.embodied, 4, 0.5, 0.25),
    ]


def outcomes_of(arm, sure):
    return [replace(static(arm, n, success), confidence=confidence) for n, (confidence, success) in enumerate(sure)]


@settings(max_examples=20, derandomize=True, deadline=None)
@given(st.lists(st.tuples(st.floats(0, 1), st.booleans()), min_size=1, max_size=60))
def test_each_step_adds_less_sure_answers_and_the_last_has_all(sure):
    rows = named(rate_by_coverage(outcomes_of(SURE, sure), 0.95))
    assert [row.coverage for row in rows] == [step / STEPS for step in range(1, STEPS + 1)]
    assert [row.answered for row in rows] == sorted(row.answered for row in rows) and rows[-1].answered == len(sure)
    lowest = [row.least_confidence for row in rows]
    assert lowest == sorted(lowest, reverse=True) and lowest[-1] == min(confidence for confidence, _ in sure)
    assert rows[-1].successes == sum(success for _, success in sure)


def test_an_answer_without_a_confidence_is_the_least_sure():
    rows = named(rate_by_coverage(outcomes_of(SURE, [(None, True), (0.25, False)]), 0.5))
    assert (rows[0].answered, rows[0].least_confidence, rows[0].successes) == (1, 0.25, 0)
    assert (rows[-1].least_confidence, rows[-1].rate) == (0.0, 0.5)
    assert (rows[-1].low, rows[-1].high) == wilson_interval(1, 2, 0.5)


def test_only_the_first_run_of_agents_that_say_how_sure_they_are_is_covered():
    control = next(arm.name for arm in ARMS if arm.control and arm.kind is Kind.STATIC and arm.ablates is None)
    ablation = next(arm.name for arm in ARMS if arm.ablates == SURE)
    said = [(0.5, True)] * 3
    runs = [replace(one, seed=seed, success=1.0 - seed) for one in outcomes_of(SURE, said) for seed in (0, 1)]
    others = [one for arm in ("a stranger", control, ablation) for one in outcomes_of(arm, said)]
    found = named(
        coverage([results("main", Kind.STATIC, [*others, *runs, *outcomes_of("two_visits", [(None, True)] * 3)])], SETTINGS)
    )
    assert [(row.arm, row.coverage) for row in found] == [(SURE, step / STEPS) for step in range(1, STEPS + 1)]
    assert all(row.rate == 1.0 for row in found)


@pytest.fixture(scope="module")
def across(tmp_path_factory):
    folder = tmp_path_factory.mktemp("metrics")
    write_across_splits({split: DATA / "metrics" / split for split in ("main", "multi", "everyday")}, SETTINGS, folder)
    return folder


def test_the_readme_shows_rates_of_the_release(across):
    """Compare each row of its table, by the beginning of the title."""
    table = make_table(TABLES["overview"], read_metrics(across / "overview.csv"), CONFIG).cells("csv").set_index("system")
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = re.findall(r"^\| ([^|]+?) *\|((?: +[\d.—]+ \|){4})$", text, re.MULTILINE)
    columns = [f"{split}_{kind}" for split in ("main", "everyday") for kind in ("static", "embodied")]
    assert len(lines) == 6
    for title, cells in lines:
        assert cells.replace("|", " ").split() == [
            value or "—" for value in table.loc[title.partition(", a control")[0]][columns]
        ], title
