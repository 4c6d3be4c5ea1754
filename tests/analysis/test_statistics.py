"""Intervals and tests against other formulas, enumeration, and the numbers that the paper prints."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest, norm, poisson_binom
from statsmodels.stats.contingency_tables import mcnemar
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import proportion_confint

from ovman.analysis.statistics import auroc, holm, mcnemar_exact, poisson_binomial, poisson_binomial_tail, wilson_interval

COUNTS = st.integers(1, 400).flatmap(lambda trials: st.tuples(st.integers(0, trials), st.just(trials)))
PROBABILITIES = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 1.0))


@given(COUNTS, st.sampled_from([1, 2, 3]), st.sampled_from([0.5, 0.9, 0.95, 0.99]))
def test_wilson_agrees_with_statsmodels(counts, seeds, confidence):
    """Of a mean over seeds, too, which is no whole count."""
    successes, trials = counts[0] / seeds, counts[1]
    theirs = proportion_confint(successes, trials, alpha=1.0 - confidence, method="wilson")
    assert wilson_interval(successes, trials, confidence) == pytest.approx(theirs, abs=1e-12)


@given(COUNTS, st.sampled_from([1, 2, 3]))
def test_wilson_solves_its_own_equation(counts, seeds):
    successes, trials = counts[0] / seeds, counts[1]
    z = float(norm.ppf(0.975))
    for bound in wilson_interval(successes, trials):
        assert (bound - successes / trials) ** 2 == pytest.approx(z * z * bound * (1 - bound) / trials, abs=1e-9)


@given(COUNTS)
def test_wilson_encloses_the_rate_and_mirrors(counts):
    successes, trials = counts
    low, high = wilson_interval(successes, trials)
    assert 0.0 <= low <= successes / trials <= high <= 1.0
    assert (low, high) == pytest.approx([1.0 - bound for bound in reversed(wilson_interval(trials - successes, trials))])
    wide = wilson_interval(successes, trials, 0.99)
    assert wide[0] <= low and high <= wide[1]


@pytest.mark.parametrize(("successes", "low", "high"), [(62, 0.228, 0.346), (99, 0.388, 0.518), (217, 0.967, 0.997)])
def test_wilson_gives_the_intervals_of_the_paper(successes, low, high):
    assert [round(bound, 3) for bound in wilson_interval(successes, 219)] == [low, high]


@pytest.mark.parametrize(("successes", "trials", "confidence"), [(1, 0, 0.95), (3, 2, 0.95), (-1, 2, 0.95), (1, 2, 1.0)])
def test_wilson_refuses_what_is_no_rate(successes, trials, confidence):
    with pytest.raises(ValueError, match="not a rate|confidence"):
        wilson_interval(successes, trials, confidence)


@given(st.integers(0, 120), st.integers(0, 120))
def test_mcnemar_is_the_two_sided_sign_test(wins, losses):
    p = mcnemar_exact(wins, losses)
    assert p == mcnemar_exact(losses, wins)
    assert p == pytest.approx(float(mcnemar([[7, wins], [losses, 3]], exact=True).pvalue), rel=1e-9)
    if wins + losses:
        assert p == pytest.approx(binomtest(wins, wins + losses).pvalue, rel=1e-9)
    else:
        assert p == 1.0
    # By enumeration, in whole numbers: both tails as far out as the smaller count.
    pairs = wins + losses
    outer = sum(math.comb(pairs, k) for k in range(min(wins, losses) + 1))
    assert p == pytest.approx(float(min(Fraction(1), Fraction(2 * outer, 2**pairs))), rel=1e-9)


def test_mcnemar_gives_the_tests_of_the_paper():
    assert mcnemar_exact(49, 35) == pytest.approx(0.16, abs=0.005)
    assert mcnemar_exact(83, 11) < 1e-14
    assert mcnemar_exact(59, 22) < 1e-4
    assert mcnemar_exact(1, 0) == 1.0
    assert mcnemar_exact(6, 0) == 2 / 64


def test_mcnemar_refuses_negative_counts():
    with pytest.raises(ValueError, match="at least 0"):
        mcnemar_exact(-1, 3)


@given(st.lists(PROBABILITIES, max_size=7), st.integers(-1, 8))
def test_the_tail_agrees_with_enumeration(probabilities, successes):
    expected = math.fsum(
        math.prod(p if hit else 1.0 - p for p, hit in zip(probabilities, outcome, strict=True))
        for outcome in itertools.product([False, True], repeat=len(probabilities))
        if sum(outcome) >= successes
    )
    assert poisson_binomial_tail(probabilities, successes) == pytest.approx(expected, abs=1e-12)


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


@given(st.integers(1, 250), st.floats(0.01, 0.99), st.integers(0, 250))
def test_equal_probabilities_make_it_binomial_to_relative_precision(trials, probability, successes):
    expected = float(binom.sf(successes - 1, trials, probability))
    assert poisson_binomial_tail([probability] * trials, successes) == pytest.approx(expected, rel=1e-8, abs=1e-290)


@pytest.mark.parametrize("probability", [-0.1, 1.1, float("nan")])
def test_the_tail_refuses_what_is_no_probability(probability):
    with pytest.raises(ValueError, match="not a probability"):
        poisson_binomial_tail([0.5, probability], 1)


@given(st.lists(st.floats(0.0, 1.0), max_size=8), st.floats(0.01, 0.99))
def test_holm_rejects_exactly_what_the_step_down_procedure_rejects(p_values, level):
    rejected, remaining = set(), len(p_values)
    for k in sorted(range(len(p_values)), key=lambda k: p_values[k]):
        if p_values[k] * remaining > level:
            break
        rejected.add(k)
        remaining -= 1
    assert {k for k, p in enumerate(holm(p_values)) if p <= level} == rejected


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8))
def test_holm_agrees_with_statsmodels(p_values):
    with patch("gc.collect"):  # which statsmodels does at every correction, and takes longer than all else here
        theirs = multipletests(p_values, method="holm")[1]
    assert holm(p_values) == pytest.approx(theirs, abs=1e-15)


def test_holm_on_a_family_worked_by_hand():
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert holm([]) == ()
    with pytest.raises(ValueError, match="not a p-value"):
        holm([0.5, 1.5])


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
