"""Success next to the chance of 1/n, and failures. `make golden` has the other breakdowns."""

from __future__ import annotations

import math

import pytest

from ovman.analysis.breakdowns import Verdict, budget, judge_failure, shortcuts
from ovman.analysis.rates import arm_rates
from ovman.settings import Kind
from tests.analysis.fabricated import embodied, over_all, static
from tests.arms import CONFIG

R, NEAR = 1.0, 2.0


def test_a_neighbour_at_the_radius_makes_an_episode_crowded():
    near = [R, math.nextafter(R, math.inf), None, math.nextafter(R, math.inf)]
    answers = [static("answers", 6 * k, k < 2, instances=2 + 2 * (k % 2), neighbour_m=m) for k, m in enumerate(near)]
    (row,) = over_all(shortcuts(answers, R))
    assert (row.n, row.chance, row.rate, row.excess) == (4, 0.375, 0.5, 0.125)
    assert (row.crowded, row.crowded_rate, row.uncrowded_rate) == (1, 1.0, pytest.approx(1 / 3))
    (row,) = over_all(shortcuts([embodied("drives", k, False, seed) for k in range(2) for seed in (0, 1)], R))
    assert (row.kind, row.n, row.crowded, row.crowded_rate, row.uncrowded_rate) == (Kind.EMBODIED, 2, 0, None, 0.0)


@pytest.mark.parametrize(
    ("distance_m", "other_m", "expected"),
    [
        (None, 0.0, Verdict.ABSTAIN),
        (9.0, R, Verdict.WRONG_INSTANCE),
        (1.5, math.nextafter(R, 2.0), Verdict.NEAR_MISS),
        (9.0, 0.0, Verdict.WRONG_INSTANCE),
        (NEAR, None, Verdict.NEAR_MISS),
        (math.nextafter(NEAR, 3.0), None, Verdict.ELSEWHERE),
    ],
)
def test_the_distances_of_the_taxonomy_are_inclusive(distance_m, other_m, expected):
    assert judge_failure(static("arm", 0, 0, distance_m=distance_m, other_m=other_m), R, NEAR) is expected


def test_without_a_rung_there_is_no_budget():
    rungs = CONFIG.comparisons.rungs
    lowest, _, highest = rungs
    assert budget(arm_rates([static(arm, i, True) for arm in (lowest, highest) for i in range(6)], 0.95), [], rungs) == []
