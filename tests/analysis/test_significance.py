from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.comparisons import among
from ovman.analysis.significance import Method, significance
from ovman.analysis.statistics import holm, mcnemar_exact, poisson_binomial_tail
from ovman.settings import Pair
from tests.analysis.fabricated import embodied, static
from tests.arms import ARMS, CONFIG

PAIRS, PAIRINGS = tuple(CONFIG.comparisons.pairs.values()), tuple(CONFIG.comparisons.pairings.values())

PROPERTY = settings(max_examples=12, derandomize=True, deadline=None)
SUCCESSES = st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=24)
ONE, TWO, HANDED = "single_visit", "two_visits", "grounding_two_visits"


@PROPERTY
@given(SUCCESSES)
def test_wins_and_losses_are_the_discordant_episodes(successes):
    outcomes = [static(HANDED, i, ours) for i, (ours, _) in enumerate(successes)]
    outcomes += [static(TWO, i, theirs) for i, (_, theirs) in enumerate(successes)]
    rows, _ = significance(outcomes, [], PAIRS)
    *relations, whole = rows
    assert {(row.arm, row.baseline, row.test) for row in rows} == {(HANDED, TWO, Method.MCNEMAR)}
    assert whole.wins == sum(ours and not theirs for ours, theirs in successes) == sum(row.wins for row in relations)
    assert whole.losses == sum(theirs and not ours for ours, theirs in successes) == sum(row.losses for row in relations)
    assert whole.n == len(successes) == sum(row.n for row in relations)
    assert whole.p == mcnemar_exact(int(whole.wins), int(whole.losses)) and whole.p_holm is None
    assert tuple(row.p_holm for row in relations) == holm([row.p for row in relations])


@PROPERTY
@given(st.lists(st.tuples(st.booleans(), st.floats(0, 1)), min_size=1, max_size=24))
def test_against_a_stochastic_pick_wins_are_expected_and_the_test_is_its_tail(episodes):
    outcomes = [static(TWO, i, ours) for i, (ours, _) in enumerate(episodes)]
    outcomes += [static(ONE, i, p, "expected") for i, (_, p) in enumerate(episodes)]
    rows, _ = significance(outcomes, [], PAIRS)
    for row in rows:
        assert row.test is Method.POISSON_BINOMIAL
        assert row.wins - row.losses == pytest.approx(row.successes - row.baseline_successes)
        assert row.wins >= 0 and row.losses >= 0 and row.wins + row.losses <= row.n
    assert rows[-1].p == pytest.approx(poisson_binomial_tail([p for _, p in episodes], sum(ours for ours, _ in episodes)))
    assert rows[-1].baseline_successes == pytest.approx(math.fsum(p for _, p in episodes))


def test_seeds_are_paired_and_the_order_of_the_rows_does_not_matter():
    ours = [embodied("two_visits_embodied", i, (i + seed) % 2 == 0, seed) for seed in (0, 1, 2) for i in range(12)]
    theirs = [embodied("single_visit_embodied", i, i < seed, seed) for seed in (1, 0) for i in range(12)]
    rows, _ = significance([], ours + theirs, PAIRS)
    assert sorted({row.seed for row in rows}) == [0, 1]
    assert [(row.wins, row.losses) for row in rows if row.relation == "all"] == [(6, 0), (6, 1)]
    assert significance([], (theirs + ours)[::-1], PAIRS)[0] == rows


def test_what_cannot_be_paired_is_refused():
    ours, theirs = [embodied("two_visits_embodied", 0, True)], [embodied("single_visit_embodied", 0, True)]
    with pytest.raises(ValueError, match="share no seed"):
        significance([], ours + [replace(theirs[0], seed=1)], PAIRS)
    with pytest.raises(ValueError, match="not over the same episodes"):
        significance([], ours + [replace(theirs[0], episode="FloorPlan1/moved/0007")], PAIRS)
    with pytest.raises(ValueError, match="two_visits is a stochastic pick"):
        significance([static(TWO, 0, 0.5, "expected"), static(ONE, 0, 0.5, "expected")], [], PAIRS)


def test_pairs_without_an_arm_are_named_and_no_others():
    pairs, left_out = among([TWO, ONE], PAIRS)
    assert [(pair.arm, pair.baseline) for pair in pairs] == [(TWO, ONE)]
    assert len(left_out) == len(PAIRS) - 1
    assert "not compared: oracle grounding against own; there is no arm grounding_two_visits" in left_out
    everything = {name for pair in PAIRS for name in (pair.arm, pair.baseline)}
    assert among(everything, PAIRS) == (list(PAIRS), [])


def test_every_arm_that_is_missing_is_named():
    pair = Pair(name="one against another", arm="one", baseline="another")
    assert among([], [pair]) == ([], ["not compared: one against another; there is no arm one and no another"])
    assert among(["another"], [pair]) == ([], ["not compared: one against another; there is no arm one"])


def test_every_pair_is_of_arms_that_exist():
    arms = {arm.name: arm for arm in ARMS}
    for pair in (*PAIRS, *PAIRINGS):
        assert arms[pair.arm].kind is arms[pair.baseline].kind and not arms[pair.arm].expected
    assert len({pair.name for pair in (*PAIRS, *PAIRINGS)}) == len(PAIRS) + len(PAIRINGS)
