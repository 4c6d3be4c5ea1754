"""Intervals and tests against other formulas, enumeration, and the numbers that the paper prints."""

from __future__ import annotations

import math
from collections import defaultdict
from fractions import Fraction
from itertools import product
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest, poisson_binom
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import proportion_confint

from ovman.analysis.statistics import (
    FLIPS,
    auroc,
    bootstrap_interval,
    design_effect,
    draw_resamples,
    holm,
    mcnemar_exact,
    poisson_binomial,
    poisson_binomial_tail,
    sign_flip_p,
    wilson_interval,
)

COUNTS = st.integers(1, 400).flatmap(lambda trials: st.tuples(st.integers(0, trials), st.just(trials)))
PROBABILITIES = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 1.0))


@given(COUNTS, st.sampled_from([1, 2, 3]), st.sampled_from([0.5, 0.9, 0.95, 0.99]))
def test_wilson_agrees_with_statsmodels(counts, seeds, confidence):
    """For means over seeds as well, which are not whole counts."""
    successes, trials = counts[0] / seeds, counts[1]
    theirs = proportion_confint(successes, trials, alpha=1.0 - confidence, method="wilson")
    assert wilson_interval(successes, trials, confidence) == pytest.approx(theirs, abs=1e-12)


@given(st.integers(0, 120), st.integers(0, 120))
def test_mcnemar_is_the_two_sided_sign_test(wins, losses):
    p = mcnemar_exact(wins, losses)
    assert p == mcnemar_exact(losses, wins)
    assert p == pytest.approx(binomtest(wins, wins + losses).pvalue if wins + losses else 1.0, rel=1e-9)


def test_mcnemar_gives_the_tests_of_the_paper():
    assert mcnemar_exact(49, 35) == pytest.approx(0.16, abs=0.005)
    assert mcnemar_exact(83, 11) < 1e-14
    assert mcnemar_exact(59, 22) < 1e-4
    assert mcnemar_exact(1, 0) == 1.0
    assert mcnemar_exact(6, 0) == 2 / 64


def test_the_far_tail_agrees_with_whole_numbers():
    # As many episodes as the paper's, with probabilities as a stochastic pick has them: many of 0, some of 1/n, a few near 1.
    whole = 960
    shares = [0, 480, 320, 192, 90, 900, 15] * 31 + [120] * 2
    ways = [1]
    for share in shares:
        ways = [a * (whole - share) + b * share for a, b in zip([*ways, 0], [0, *ways], strict=True)]
    probabilities = [share / whole for share in shares]
    for successes in (0, 20, 41, 70, 91, 120, 180, 188, 189, 219):
        expected = Fraction(sum(ways[successes:]), whole ** len(shares))
        tail = poisson_binomial_tail(probabilities, successes)
        assert tail == pytest.approx(float(expected), rel=1e-10, abs=0.0)
        assert (tail == 0.0) == (expected == 0) == (successes > 188)
    assert 0.0 < poisson_binomial_tail(probabilities, 120) < 1e-22


@given(st.lists(PROBABILITIES, min_size=1, max_size=60))
def test_the_distribution_agrees_with_scipys(probabilities):
    theirs = poisson_binom.pmf(range(len(probabilities) + 1), probabilities)
    assert poisson_binomial(probabilities) == pytest.approx(theirs, rel=1e-9, abs=1e-300)


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8))
def test_holm_agrees_with_statsmodels(p_values):
    with patch("gc.collect"):  # which statsmodels does at every correction, and takes longer than all else here
        theirs = multipletests(p_values, method="holm")[1]
    assert holm(p_values) == pytest.approx(theirs, abs=1e-15)


def test_holm_on_a_family_worked_by_hand():
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert holm([]) == ()


SCORES = st.lists(st.one_of(st.integers(-2, 2).map(float), st.floats(-1e6, 1e6), st.just(math.inf)), min_size=1, max_size=12)


@given(SCORES, SCORES)
def test_auroc_is_the_share_of_pairs_in_order_with_ties_at_half(positive, negative):
    halves = sum(2 * (p > n) + (p == n) for p in positive for n in negative)
    assert auroc(positive, negative) == halves / (2 * len(positive) * len(negative))
    assert auroc(positive, negative) + auroc(negative, positive) == pytest.approx(1.0, abs=1e-15)


def test_auroc_of_nothing_is_no_number_and_of_no_number_is_refused():
    assert math.isnan(auroc([], [1.0])) and math.isnan(auroc([1.0], []))
    with pytest.raises(ValueError, match="not a number"):
        auroc([math.nan], [1.0])


def test_the_poisson_binomial_by_hand():
    assert poisson_binomial([]).tolist() == [1.0]
    assert poisson_binomial([0.25, 0.5]).tolist() == [0.375, 0.5, 0.125]
    assert [poisson_binomial_tail([0.25, 0.5], k) for k in (-1, 0, 1, 2, 3)] == [1.0, 1.0, 0.625, 0.125, 0.0]


def test_a_tail_is_a_probability_to_the_last_bit():
    """Where rounding makes the terms sum to less than 1, or to more."""
    assert math.fsum(poisson_binomial([0.61, 0.13])) < 1.0 == poisson_binomial_tail([0.61, 0.13], 0)
    assert math.fsum(poisson_binomial([1.0, 0.97, 0.22])[1:]) > 1.0 == poisson_binomial_tail([1.0, 0.97, 0.22], 1)


CLUSTERED = st.lists(st.tuples(st.sampled_from("abcdefg"), st.sampled_from([0.0, 0.5, 1.0])), min_size=1, max_size=40)


def by_scene(drawn) -> dict[str, list[float]]:
    groups = defaultdict(list)
    for scene, value in drawn:
        groups[scene].append(value)
    return groups


@given(CLUSTERED)
def test_flipped_signs_are_those_of_every_way_to_flip_whole_scenes(drawn):
    values, scenes = [value - 0.5 for _, value in drawn], [scene for scene, _ in drawn]
    sums = [sum(group) for group in by_scene(zip(scenes, values, strict=True)).values()]
    flipped = [
        abs(sum(sign * one for sign, one in zip(signs, sums, strict=True))) for signs in product((1, -1), repeat=len(sums))
    ]
    p = sum(one >= abs(sum(sums)) - 1e-9 for one in flipped) / len(flipped)
    assert sign_flip_p(values, scenes, "a") == pytest.approx(p)


def test_many_scenes_are_flipped_at_random_near_the_exact_p():
    scenes = list(map(str, range(40)))
    values = [1.0] * 27 + [-1.0] * 13
    assert sign_flip_p(values, scenes, "a") == pytest.approx(mcnemar_exact(27, 13), abs=4 * math.sqrt(0.04 / FLIPS))
    assert sign_flip_p([1.0] * 40, scenes, "a") == 1 / FLIPS, "never 0"


@given(CLUSTERED, st.sampled_from([0.5, 0.9, 0.95]))
def test_a_bootstrap_draws_whole_scenes(drawn, confidence):
    values, scenes = [value for _, value in drawn], [scene for scene, _ in drawn]
    groups = [by_scene(drawn)[name] for name in sorted({*scenes})]
    interval = bootstrap_interval(values, scenes, "a", confidence)
    means = []
    for weights in draw_resamples(len(groups), "a"):
        picked = [value for group, times in zip(groups, weights, strict=True) for value in group * times]
        means.append(sum(picked) / len(picked))
    if interval is None:
        assert np.ptp([np.mean(group) for group in groups]) == 0
    else:
        ends = (1 - confidence) / 2, (1 + confidence) / 2
        assert interval == pytest.approx(tuple(np.quantile(means, ends)))


@given(CLUSTERED)
def test_the_design_effect_is_that_of_a_ratio_and_absent_where_nothing_varies(drawn):
    values, scenes = [value for _, value in drawn], [scene for scene, _ in drawn]
    effect, groups = design_effect(values, scenes), by_scene(drawn)
    if len(groups) < 2 or len({*values}) == 1:
        assert effect is None
    else:
        mean, k = np.mean(values), len(groups)
        between = sum((sum(group) - mean * len(group)) ** 2 for group in groups.values()) * k / (k - 1) / len(values) ** 2
        assert effect == pytest.approx(between / (np.var(values) / len(values)))
        assert not math.isnan(effect)


def test_scenes_of_one_answer_cost_their_size_and_independent_ones_nothing():
    whole = design_effect([1.0] * 50 + [0.0] * 50, [str(k // 5) for k in range(100)])
    assert whole == pytest.approx(5 * 20 / 19), "ten scenes of five equal answers each way: a scene is worth one episode"
    rng = np.random.default_rng(0)
    effects = [
        design_effect(rng.integers(0, 2, 400).astype(float).tolist(), [str(k % 40) for k in range(400)]) for _ in range(200)
    ]
    assert np.mean(effects) == pytest.approx(1.0, abs=0.05)


def test_a_rate_of_one_has_neither_interval_nor_design_effect():
    assert bootstrap_interval([1.0] * 6, list("aabbcc"), "a") is None and design_effect([1.0] * 6, list("aabbcc")) is None


def test_splits_of_one_size_are_resampled_apart_and_the_same_split_alike():
    assert (draw_resamples(20, "main") == draw_resamples(20, "main")).all()
    assert (draw_resamples(20, "main") != draw_resamples(20, "everyday")).any()
    assert (draw_resamples(20, "main").sum(axis=1) == 20).all()


def test_the_interval_covers_as_often_as_it_says():
    """Scenes with rates of their own: episodes alone would cover less."""
    rng, covered, narrow = np.random.default_rng(1), [], []
    scenes = [str(k // 8) for k in range(320)]
    for _ in range(150):
        rates = np.repeat(rng.beta(2, 2, 40), 8)
        values = (rng.random(320) < rates).astype(float)
        low, high = bootstrap_interval(values.tolist(), scenes, "a")
        covered.append(low <= 0.5 <= high)
        low, high = wilson_interval(values.sum(), 320)
        narrow.append(low <= 0.5 <= high)
    assert np.mean(covered) >= 0.9 > np.mean(narrow)
