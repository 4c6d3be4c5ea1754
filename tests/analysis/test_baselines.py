"""Arms with several runs against others, tasks of an agent's own, spread over seeds, scenes; on the paper's own counts, too."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.comparisons import among
from ovman.analysis.own_task import own_task
from ovman.analysis.pairings import Pairing, pairings
from ovman.analysis.rates import Interval, embodied_rates, expected_range, poisson_binomial_range, static_rates
from ovman.analysis.scenes import SceneRate, scenes
from ovman.analysis.significance import Method, significance
from ovman.analysis.spread import Pass, passes
from ovman.analysis.statistics import holm, mcnemar_exact, poisson_binomial_tail, wilson_interval
from ovman.analysis.taxonomy import Verdict, taxonomy
from ovman.settings import Kind, Pair
from tests.analysis.fabricated import ROUND, embodied, static
from tests.arms import CONFIG

PROPERTY = settings(max_examples=20, derandomize=True, deadline=None)
READINGS = Pair(name="readings", arm="dualmap_two_visits", baseline="dualmap_maintained")
PAIRS, PAIRINGS = tuple(CONFIG.comparisons.pairs.values()), tuple(CONFIG.comparisons.pairings.values())
N = 219
RUNS = st.integers(1, 12).flatmap(lambda n: st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=1, max_size=3))


def runs_of(arm, runs):
    """The outcomes of a static arm: one list of successes (or probabilities) a run."""
    kinds = ["expected" if any(p not in (0, 1) for run in runs for p in run) else "answered"] * len(runs)
    return [
        static(arm, i, p, kind, seed=seed)
        for seed, (run, kind) in enumerate(zip(runs, kinds, strict=True))
        for i, p in enumerate(run)
    ]


# The paper's counts.


def test_83_wins_to_11_losses_is_what_the_paper_says_of_it():
    assert 1e-16 < mcnemar_exact(83, 11) < 1e-14
    ours = [embodied("two_visits_embodied", i, i < 99) for i in range(N)]
    theirs = [embodied("cow", i, 83 <= i < 110) for i in range(N)]
    whole = [row for row in significance([], ours + theirs, PAIRS)[0] if row.baseline == "cow"][-1]
    assert (whole.successes, whole.baseline_successes, whole.wins, whole.losses) == (99, 27, 83, 11)
    assert (round(99 / N, 3), round(27 / N, 3)) == (0.452, 0.123)
    assert whole.p == mcnemar_exact(83, 11)


def test_73_of_219_runs_on_the_own_task_against_27_on_this_one():
    runs = [embodied("cow", i, i < 27, own_success=i < 73) for i in range(N)]
    whole = own_task(runs)[-1]
    assert (whole.relation, whole.n, whole.own_successes, whole.successes) == ("all", N, 73, 27)
    assert (round(whole.own_rate, 3), round(whole.rate, 3), round(whole.gap, 3)) == (0.333, 0.123, 0.210)
    assert (whole.only_own, whole.only_here) == (46, 0) and whole.p == pytest.approx(2 * 0.5**46)


def test_rates_of_three_runs_are_the_papers_where_its_counts_are_known():
    # DualMap's maintained map: 20, 18, 15, 19, 16 and 22 successes in three runs over 33, 38, 36, 32, 40 and 40 episodes.
    counts = {
        "moved": (20, 33),
        "former": (18, 38),
        "moving": (15, 36),
        "stable": (19, 32),
        "appeared": (16, 40),
        "removed": (22, 40),
    }
    outcomes = []
    for relation, (successes, episodes) in counts.items():
        place = [r.value for r in ROUND].index(relation)
        for k in range(3 * episodes):
            run, i = divmod(k, episodes)
            outcomes.append(static("dualmap_maintained", place + 6 * i, k % (3 * episodes) < successes, seed=run))
    rates = {rate.relation: rate for rate in static_rates(outcomes, 0.95)}
    assert {relation: round(rate.rate, 3) for relation, rate in rates.items()} == {
        "moved": 0.202, "former": 0.158, "moving": 0.139, "stable": 0.198, "appeared": 0.133, "removed": 0.183, "all": 0.167,
    }  # fmt: skip
    whole = rates["all"]
    assert (whole.n, whole.seeds, whole.trials, whole.successes) == (N, 3, 3 * N, 110)
    assert (whole.low, whole.high) == wilson_interval(110 / 3, N, 0.95)


# Several runs of a static arm.


@PROPERTY
@given(RUNS)
def test_runs_add_no_episodes(runs):
    whole = static_rates(runs_of("dualmap_maintained", runs), 0.95)[-1]
    n, single = len(runs[0]), [sum(run) / len(run) for run in runs]
    assert (whole.n, whole.seeds, whole.trials) == (n, len(runs), n * len(runs))
    assert whole.rate == pytest.approx(sum(single) / len(runs)) and whole.low <= whole.rate <= whole.high
    assert (whole.low, whole.high) == wilson_interval(sum(map(sum, runs)) / len(runs), n, 0.95)
    assert (whole.least, whole.greatest) == ((None, None) if len(runs) == 1 else (min(single), max(single)))
    again = static_rates(runs_of("dualmap_maintained", [runs[0]] * 3), 0.95)[-1]
    once = static_rates(runs_of("dualmap_maintained", runs[:1]), 0.95)[-1]
    assert (again.low, again.high) == pytest.approx((once.low, once.high))


@PROPERTY
@given(st.lists(st.floats(0, 1), min_size=1, max_size=12), st.integers(2, 4))
def test_the_range_of_an_expectation_does_not_narrow_with_the_number_of_runs(probabilities, runs):
    assert expected_range([probabilities] * runs, 0.9) == poisson_binomial_range(probabilities, 0.9)


def test_the_range_over_runs_is_that_of_a_run_drawn_at_random():
    assert expected_range([[0.0] * 4, [1.0] * 4], 0.95) == (0.0, 1.0)
    assert expected_range([[1.0, 0.0], [0.0, 1.0]], 0.95) == (0.5, 0.5)
    rates = static_rates(runs_of("dualmap_maintained", [[0.5, 0.25], [0.5, 0.75]]), 0.95)
    assert rates[-1].interval is Interval.POISSON_BINOMIAL and (rates[-1].rate, rates[-1].n) == (0.5, 2)
    assert (rates[-1].least, rates[-1].greatest) == (0.375, 0.625)


@PROPERTY
@given(RUNS)
def test_the_verdicts_of_each_run_are_a_partition(runs):
    rows = taxonomy(runs_of("dualmap_two_visits", runs), [], 1.0, 2.0)
    marks = list(range(len(runs))) if len(runs) > 1 else [None]
    assert list(dict.fromkeys(row.seed for row in rows)) == marks
    for mark, run in zip(marks, runs, strict=True):
        counts = {row.verdict: row.episodes for row in rows if (row.seed, row.relation) == (mark, "all")}
        assert list(counts) == [which.value for which in Verdict]
        assert sum(counts.values()) == len(run) and counts["success"] == sum(run)


# Every run against every run.


@PROPERTY
@given(RUNS, st.data())
def test_every_run_meets_every_run_once(arm, data):
    n = len(arm[0])
    baseline = data.draw(st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=1, max_size=3))
    rows, left_out = pairings((runs_of(READINGS.arm, arm) + runs_of(READINGS.baseline, baseline))[::-1], [READINGS])
    assert left_out == []
    whole = {(row.arm_run, row.baseline_run): row for row in rows if row.relation == "all"}
    assert list(whole) == [(i, j) for i in range(len(arm)) for j in range(len(baseline))]
    for (i, j), row in whole.items():
        wins = sum(a and not b for a, b in zip(arm[i], baseline[j], strict=True))
        losses = sum(b and not a for a, b in zip(arm[i], baseline[j], strict=True))
        assert (row.wins, row.losses, row.p, row.test) == (wins, losses, mcnemar_exact(wins, losses), Method.MCNEMAR)
        assert row.difference == pytest.approx((sum(arm[i]) - sum(baseline[j])) / n) and row.p_holm is None
        relations = [r for r in rows if (r.arm_run, r.baseline_run) == (i, j) and r.relation != "all"]
        assert row.wins == sum(r.wins for r in relations)
        assert tuple(r.p_holm for r in relations) == holm([r.p for r in relations])


def test_the_mean_over_the_pairings_is_the_difference_of_the_means():
    outcomes = runs_of(READINGS.arm, [[1, 1, 0, 0], [1, 0, 0, 0], [1, 1, 1, 0]])
    outcomes += runs_of(READINGS.baseline, [[0, 0, 0, 1], [0, 1, 0, 1], [0, 0, 0, 0]])
    whole = [row for row in pairings(outcomes, [READINGS])[0] if row.relation == "all"]
    rates = {rate.arm: rate.rate for rate in static_rates(outcomes, 0.95) if rate.relation == "all"}
    assert len(whole) == 9
    assert math.fsum(row.difference for row in whole) / 9 == pytest.approx(rates[READINGS.arm] - rates[READINGS.baseline])
    assert (min(row.difference for row in whole), max(row.difference for row in whole)) == (-0.25, 0.75)


def test_a_maintained_map_that_is_picked_from_is_tested_as_a_pick():
    pick = [[0.5, 0.25, 0.0, 1.0], [0.0, 0.25, 0.5, 0.5]]
    rows, _ = pairings(runs_of(READINGS.arm, [[1, 0, 0, 1]]) + runs_of(READINGS.baseline, pick), [READINGS])
    whole = [row for row in rows if row.relation == "all"]
    assert [row.test for row in whole] == [Method.POISSON_BINOMIAL] * 2
    assert [row.p for row in whole] == pytest.approx([poisson_binomial_tail(run, 2) for run in pick])
    assert [row.difference for row in whole] == pytest.approx([(2 - 1.75) / 4, (2 - 1.25) / 4])


def test_a_pairing_says_which_run_met_which():
    outcomes = runs_of(READINGS.arm, [[1, 1, 1]]) + runs_of(READINGS.baseline, [[1, 1, 1], [1, 0, 0]])
    whole = [row for row in pairings(outcomes, [READINGS])[0] if row.relation == "all"]
    titled = (READINGS.name, READINGS.arm, READINGS.baseline, 0)
    assert whole == [
        Pairing(*titled, 0, "all", 3, 3, 3.0, 0.0, 0.0, 0.0, Method.MCNEMAR, 1.0, None),
        Pairing(*titled, 1, "all", 3, 3, 1.0, 2 / 3, 2.0, 0.0, Method.MCNEMAR, 0.5, None),
    ]


def test_runs_over_other_episodes_are_refused():
    outcomes = runs_of(READINGS.arm, [[1, 0]]) + runs_of(READINGS.baseline, [[1, 0, 1]])
    with pytest.raises(ValueError, match="not over the same episodes"):
        pairings(outcomes, [READINGS])


def test_without_the_baselines_nothing_is_paired_and_each_pair_is_named():
    rows, left_out = pairings([static("two_visits", 0, 1)], PAIRINGS)
    assert rows == [] and len(left_out) == len(PAIRINGS) == 11
    assert all(line.startswith("not compared: ") for line in left_out)
    everything = {name for pair in PAIRINGS for name in (pair.arm, pair.baseline)}
    assert among(everything, PAIRINGS) == (list(PAIRINGS), [])


# A task of its own.


@PROPERTY
@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=30))
def test_one_run_under_two_tests(runs):
    outcomes = [embodied("cow", i, here, own_success=own) for i, (here, own) in enumerate(runs)]
    rows = own_task(outcomes + [embodied("oracle_check", i, True) for i in range(len(runs))])
    *relations, whole = rows
    assert {row.arm for row in rows} == {"cow"}
    assert whole.own_successes - whole.successes == whole.only_own - whole.only_here == round(whole.gap * whole.n)
    assert whole.p == mcnemar_exact(whole.only_own, whole.only_here)
    for name in ("n", "own_successes", "successes", "only_own", "only_here"):
        assert getattr(whole, name) == sum(getattr(row, name) for row in relations)


def test_own_tasks_are_by_seed_and_never_of_some_runs_alone():
    outcomes = [embodied("cow", i, False, seed, own_success=i < seed) for seed in (2, 0, 1) for i in range(3)]
    assert [(row.seed, row.own_successes) for row in own_task(outcomes) if row.relation == "all"] == [(0, 0), (1, 1), (2, 2)]
    with pytest.raises(ValueError, match="cow: 1 of 9 runs have no verdict on its own task; judge them all again"):
        own_task([replace(outcomes[0], own_success=None), *outcomes[1:]])


def test_an_arm_without_a_task_of_its_own_has_no_rows_and_hides_no_other():
    outcomes = [embodied("two_visits_embodied", 0, True), embodied("cow", 0, False, own_success=True)]
    assert [(row.arm, row.relation) for row in own_task(outcomes)] == [("cow", "moved"), ("cow", "all")]


# Seeds and scenes.


@PROPERTY
@given(RUNS)
def test_the_passes_of_an_arm_are_what_its_rate_is_the_mean_of(runs):
    rows = passes(runs_of("dualmap_maintained", runs) + [static("two_visits", 0, 1)], [])
    whole = [row for row in rows if row.relation == "all"]
    assert [row.seed for row in whole] == (list(range(len(runs))) if len(runs) > 1 else [])
    rate = static_rates(runs_of("dualmap_maintained", runs), 0.95)[-1]
    if whole:
        assert sum(row.rate for row in whole) / len(whole) == pytest.approx(rate.rate)
        assert (min(row.rate for row in whole), max(row.rate for row in whole)) == (rate.least, rate.greatest)


def test_a_drive_is_a_pass_even_if_there_is_one():
    rows = passes([static("two_visits", 0, 1)], [embodied("cow", 0, True)])
    assert [(row.kind, row.arm, row.relation, row.seed, row.rate) for row in rows] == [
        (Kind.EMBODIED, "cow", relation, 0, 1.0) for relation in ("moved", "all")
    ]


def test_scenes_add_up_to_all_for_static_and_embodied_arms_alike():
    names = ("FloorPlan2", "FloorPlan10", "FloorPlan201")
    answers = [
        static("dualmap_maintained", i, (i + seed) % 3 == 0, seed=seed, scene=names[i % 3]) for seed in (0, 1) for i in range(14)
    ]
    runs = [embodied("cow", i, i % 4 == seed, seed, scene=names[i % 3]) for seed in (0, 1) for i in range(14)]
    rows = scenes(answers, runs, 0.95)
    assert [(row.arm, row.scene) for row in rows] == [(arm, name) for arm in ("dualmap_maintained", "cow") for name in names]
    for arm, whole in (("dualmap_maintained", static_rates(answers, 0.95)[-1]), ("cow", embodied_rates(runs, 0.95)[-1])):
        of_arm = [row for row in rows if row.arm == arm]
        assert sum(row.n for row in of_arm) == whole.n == 14 and {row.seeds for row in of_arm} == {2}
        assert math.fsum(row.rate * row.n for row in of_arm) / 14 == pytest.approx(whole.rate)


def test_a_pass_and_a_scene_say_what_they_count():
    answers = [static("answers", 6 * i, (i + seed) % 3 == 0, seed=seed) for seed in (0, 1) for i in range(4)]
    drives = [embodied("drives", 6 * i, i < 3) for i in range(4)]
    assert passes(answers, drives) == [
        Pass(kind, arm, relation, seed, 4, successes, successes / 4)
        for kind, arm, found in ((Kind.STATIC, "answers", (2.0, 1.0)), (Kind.EMBODIED, "drives", (3.0,)))
        for relation in ("moved", "all")
        for seed, successes in enumerate(found)
    ]
    several, single = wilson_interval(1.5, 4, 0.5), wilson_interval(3, 4, 0.5)
    assert scenes(answers, drives, 0.5) == [
        SceneRate(Kind.STATIC, "answers", "FloorPlan1", 4, 2, 3.0, 0.375, *several, Interval.WILSON, 0.5, 0.25, 0.5),
        SceneRate(Kind.EMBODIED, "drives", "FloorPlan1", 4, 1, 3.0, 0.75, *single, Interval.WILSON, 0.5, None, None),
    ]
