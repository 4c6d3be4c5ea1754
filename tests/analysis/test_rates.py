"""Rates of any grouping of outcomes and their intervals."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.outcomes import groups
from ovman.analysis.rates import Interval, arm_rates, chances, expected_range, rates
from ovman.analysis.statistics import wilson_interval
from tests.analysis.fabricated import ROUND, named, static

PROPERTY = settings(max_examples=20, derandomize=True, deadline=None)
RUNS = st.integers(1, 12).flatmap(lambda n: st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=1, max_size=3))


def runs_of(arm, runs, outcome="answered"):
    return [static(arm, i, p, outcome, seed=seed) for seed, run in enumerate(runs) for i, p in enumerate(run)]


@PROPERTY
@given(RUNS)
def test_runs_add_no_episodes(runs):
    whole = arm_rates(runs_of("arm", runs), 0.95)[-1]
    n, single = len(runs[0]), [sum(run) / len(run) for run in runs]
    assert (whole.n, whole.seeds, whole.trials) == (n, len(runs), n * len(runs))
    assert whole.rate == pytest.approx(sum(single) / len(runs))
    assert (whole.low, whole.high) == wilson_interval(sum(map(sum, runs)) / len(runs), n, 0.95)
    assert (whole.least, whole.greatest) == ((None, None) if len(runs) == 1 else (min(single), max(single)))


def central_range(probabilities, confidence):
    """Compute the range in fractions: below low and above high lies at most (1 - confidence) / 2, and as much as may."""
    n, exact = len(probabilities), [Fraction(1)]
    for p in probabilities:
        exact = [a * (1 - p) + b * p for a, b in zip([*exact, 0], [0, *exact], strict=True)]
    outside = (1 - confidence) / 2
    low = max(k for k in range(n + 1) if sum(exact[:k]) <= outside)
    high = min(k for k in range(n + 1) if sum(exact[k + 1 :]) <= outside)
    return low / n, high / n


@pytest.mark.parametrize("confidence", [0.25, 0.375, 0.5, 0.75, 0.875, 0.95])
@pytest.mark.parametrize("probabilities", [[0.5, 0.5], [0.5], [0.25, 0.5, 0.75], [0.5] * 4, [1.0, 1.0, 0.0], [0.0], [1.0]])
def test_the_central_range_leaves_at_most_half_of_the_rest_on_each_side(probabilities, confidence):
    assert expected_range([probabilities], confidence) == central_range(
        [Fraction(p) for p in probabilities], Fraction(confidence)
    )


def test_the_range_over_runs_is_that_of_a_run_drawn_at_random():
    assert expected_range([[0.0] * 4, [1.0] * 4], 0.95) == (0.0, 1.0)
    assert expected_range([[0.0, 0.0]] * 3 + [[1.0, 1.0]], 0.25) == (0.0, 0.0)
    assert expected_range([[0.0, 0.0]] * 3 + [[1.0, 1.0]], 0.75) == (0.0, 1.0)
    whole = arm_rates(runs_of("arm", [[0.5, 0.25], [0.5, 0.75]], "expected"), 0.95)[-1]
    assert whole.interval is Interval.POISSON_BINOMIAL and (whole.rate, whole.n) == (0.5, 2)
    assert (whole.least, whole.greatest, whole.spl) == (0.375, 0.625, None)


def test_groups_are_ordered_and_any_columns_can_be_named():
    outcomes = [
        static(arm, k, k % 2, scene=f"FloorPlan{scene}", seed=seed, instances=2 + k)
        for arm in "ba"
        for seed in (1, 0)
        for scene in (10, 9)
        for k in (5, 2, 0)
    ]
    assert [key for key, _ in groups(outcomes, "arm", "seed").items()] == [("b", 0), ("b", 1), ("a", 0), ("a", 1)]
    assert [relation for (relation,) in groups(outcomes, "relation")] == [*(ROUND[k] for k in (0, 2, 5)), "all"]
    rows = named(rates(outcomes, ("scene", "arm"), 0.95))
    assert [(row.scene, row.arm) for row in rows] == [(f"FloorPlan{n}", arm) for n in (9, 10) for arm in "ba"]
    assert {row.n for row in rows} == {3} and math.fsum(row.successes for row in rows) == sum(one.success for one in outcomes)
    assert [group for (group,) in groups(outcomes, "instance_group")] == ["2", "4+"]
    assert groups([], "arm") == {}


def test_chances_are_means_over_episodes():
    outcomes = [
        static("arm", k, 1, instances=n, alike=m, seed=s) for s in (0, 1) for k, n, m in ((0, 2, 1), (6, 4, 5), (1, 5, 4))
    ]
    found = chances(outcomes)
    assert found["moved"] == pytest.approx((0.375, 0.6)) and found["former"] == pytest.approx((0.2, 0.25))
    assert found["all"] == pytest.approx((0.95 / 3, 1.45 / 3)) and chances([]) == {}
