"""Arm against arm, run against run: wins, losses and exact tests."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.comparisons import Method, compare, pairings, significance
from ovman.analysis.statistics import holm, mcnemar_exact, poisson_binomial_tail
from ovman.settings import Pair
from tests.analysis.fabricated import embodied, static

PROPERTY = settings(max_examples=15, derandomize=True, deadline=None)
PAIR = Pair(name="ours against theirs", arm="ours", baseline="theirs")
EPISODES = st.lists(st.tuples(st.booleans(), st.floats(0, 1)), min_size=1, max_size=24)


@PROPERTY
@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=24))
def test_wins_and_losses_are_the_discordant_episodes(successes):
    outcomes = [static("ours", i, ours) for i, (ours, _) in enumerate(successes)]
    outcomes += [static("theirs", i, theirs) for i, (_, theirs) in reversed(list(enumerate(successes)))]
    *relations, whole = significance(outcomes, [PAIR])
    assert whole.wins == sum(ours and not theirs for ours, theirs in successes) == sum(row.wins for row in relations)
    assert whole.losses == sum(theirs and not ours for ours, theirs in successes) == sum(row.losses for row in relations)
    assert whole.n == len(successes) == sum(row.n for row in relations) and whole.test is Method.MCNEMAR
    assert whole.p == mcnemar_exact(int(whole.wins), int(whole.losses)) and whole.p_holm is None
    assert tuple(row.p_holm for row in relations) == holm([row.p for row in relations])


@PROPERTY
@given(EPISODES)
def test_against_a_stochastic_pick_wins_are_expected_and_the_test_is_its_tail(episodes):
    outcomes = [static("ours", i, ours) for i, (ours, _) in enumerate(episodes)]
    outcomes += [static("theirs", i, p, "expected") for i, (_, p) in enumerate(episodes)]
    rows = significance(outcomes, [PAIR])
    for row in rows:
        assert row.test is Method.POISSON_BINOMIAL and row.wins + row.losses <= row.n
        assert row.wins - row.losses == pytest.approx(row.successes - row.baseline_successes)
    assert rows[-1].p == pytest.approx(poisson_binomial_tail([p for _, p in episodes], sum(ours for ours, _ in episodes)))
    assert rows[-1].baseline_successes == pytest.approx(math.fsum(p for _, p in episodes))


def test_seeds_are_paired():
    ours = [embodied("ours", i, (i + seed) % 2 == 0, seed) for seed in (0, 1, 2) for i in range(12)]
    theirs = [embodied("theirs", i, i < seed, seed) for seed in (1, 0) for i in range(12)]
    rows = significance(ours + theirs, [PAIR])
    assert [(row.seed, row.wins, row.losses) for row in rows if row.relation == "all"] == [(0, 6, 0), (1, 6, 1)]


def test_what_cannot_be_compared_is_refused_and_a_pair_without_an_arm_left_out():
    ours, theirs = embodied("ours", 0, True), embodied("theirs", 0, True)
    with pytest.raises(ValueError, match="share no seed"):
        significance([ours, replace(theirs, seed=1)], [PAIR])
    with pytest.raises(ValueError, match="not over the same episodes"):
        compare(PAIR, 0, [ours], [replace(theirs, episode="FloorPlan1/moved/0007")])
    with pytest.raises(ValueError, match="ours is a stochastic pick"):
        significance([static("ours", 0, 0.5, "expected"), static("theirs", 0, 0.5, "expected")], [PAIR])
    assert significance([ours], [PAIR]) == [] == pairings([ours], [PAIR])
