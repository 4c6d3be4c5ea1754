"""Success by coverage: the surest first, each share once, and nothing of arms that do not say how sure they are."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis import coverage, frames
from ovman.analysis.controls import Judged
from ovman.analysis.coverage import STEPS, Coverage, covered, of_split
from ovman.analysis.outcomes import StaticOutcome
from ovman.analysis.statistics import wilson_interval
from ovman.report.figures.rates import draw_coverage
from ovman.report.metrics import Metrics, name_arms
from ovman.report.tables.coverage import SHOWN, coverage_table
from ovman.report.tables.table import markdown
from ovman.settings import Kind
from ovman.workflow.parameter import stage_settings
from tests.analysis.fabricated import static
from tests.arms import ARMS, CONFIG

CONSTANTS = stage_settings(CONFIG, "controls")
SURE = next(arm.name for arm in ARMS if arm.kind is Kind.STATIC and any(other.ablates == arm.name for other in ARMS))
"""An agent of which there are ablations; they and its controls say how sure they are, too."""


def outcomes(arm: str, sure: list[tuple[float | None, bool]]) -> list[StaticOutcome]:
    return [replace(static(arm, n, success), confidence=confidence) for n, (confidence, success) in enumerate(sure)]


@given(st.lists(st.tuples(st.floats(0, 1), st.booleans()), min_size=1, max_size=60))
def test_each_step_adds_less_sure_answers_and_the_last_has_all(sure):
    rows = covered("main", outcomes(SURE, sure), 0.95)
    assert [row.coverage for row in rows] == [step / STEPS for step in range(1, STEPS + 1)]
    assert [row.answered for row in rows] == sorted(row.answered for row in rows) and rows[-1].answered == len(sure)
    least = [row.least_confidence for row in rows]
    assert least == sorted(least, reverse=True) and least[-1] == min(confidence for confidence, _ in sure)
    assert rows[-1].successes == sum(success for _, success in sure)
    assert all(row.low <= row.rate <= row.high for row in rows)


def test_who_is_sure_of_what_is_right_gains_by_silence():
    rows = covered("main", outcomes(SURE, [(n / 100, n >= 50) for n in range(100)]), 0.95)
    assert [row.rate for row in rows if row.coverage <= 0.5] == [1.0] * (STEPS // 2) and rows[-1].rate == 0.5
    inverse = covered("main", outcomes(SURE, [(n / 100, n < 50) for n in range(100)]), 0.95)
    assert inverse[0].rate == 0.0 and inverse[-1].rate == 0.5


def test_an_answer_without_a_confidence_is_the_least_sure():
    rows = covered("main", outcomes(SURE, [(None, True), (0.25, False)]), 0.5)
    assert rows[0] == Coverage("main", SURE, 1 / STEPS, 1, 0.25, 0, 0.0, *wilson_interval(0, 1, 0.5))
    assert rows[-1] == Coverage("main", SURE, 1.0, 2, 0.0, 1, 0.5, *wilson_interval(1, 2, 0.5))


def test_the_first_run_of_each_agent_counts_whoever_stands_between_them(tmp_path):
    control = next(arm.name for arm in ARMS if arm.control and arm.kind is Kind.STATIC and arm.ablates is None)
    said = [(0.5, True)] * 3
    runs = [replace(one, seed=seed, success=1.0 - seed) for one in outcomes(SURE, said) for seed in (0, 1)]
    rows = [*outcomes("a stranger", said), *runs, *outcomes(control, said), *outcomes("two_visits", said)]
    frames.write(tmp_path / "static_outcomes.csv", StaticOutcome, rows)
    judged = Judged("main", Kind.STATIC, tmp_path / "static_rates.csv", tmp_path / "static_outcomes.csv")
    found = of_split(judged, CONSTANTS)
    assert [(row.arm, row.coverage) for row in found] == [
        (arm, step / STEPS) for arm in (SURE, "two_visits") for step in range(1, STEPS + 1)
    ]
    assert all(row.rate == 1.0 for row in found)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    directory = tmp_path_factory.mktemp("outcomes")
    every = [arm.name for arm in ARMS if arm.kind is Kind.STATIC and (arm.ablates == SURE or arm.name == SURE)]
    rows = [one for arm in every for one in outcomes(arm, [(n / 12, n % 2 == 0) for n in range(12)])]
    rows += outcomes("two_visits", [(None, True)] * 12)
    for name in ("static", "multi"):
        frames.write(directory / f"{name}_outcomes.csv", StaticOutcome, rows)
    paths = [[directory / f"{name}_{what}.csv" for name in ("static", "multi")] for what in ("rates", "outcomes")]
    coverage.run(*paths, CONSTANTS, directory / "coverage.csv")
    return directory / "coverage.csv"


def test_only_agents_that_say_how_sure_they_are_have_rows(files):
    rows = frames.read_rows(files, Coverage)
    assert [(row.split, row.arm) for row in rows] == [(split, SURE) for split in ("main", "multi") for _ in range(STEPS)]


def test_the_table_and_the_figure_are_there_without_rows(files, tmp_path):
    table = coverage_table(frames.read(files, Coverage), CONFIG)
    assert len(table.rows) == 2 * len(SHOWN) and "nan" not in markdown(table)
    assert len(coverage_table(frames.frame_of(Coverage, []), CONFIG).rows) == 0
    by_row = name_arms(CONFIG.comparisons, CONFIG.paper)
    for name, paths in (("one", [files]), ("other", [files]), ("nothing", [])):
        draw_coverage(Metrics.load(paths, by_row), CONFIG, tmp_path / f"{name}.png")
    one, other, nothing = ((tmp_path / f"{name}.png").read_bytes() for name in ("one", "other", "nothing"))
    assert one == other != nothing
