"""The probability that a stochastic pick succeeds."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.evaluation.scores import success_probability
from ovman.records.prediction import UniformBox, UniformPick

RADIUS = 1.0
coordinate = st.floats(-4, 4).map(lambda value: round(value, 3))
candidates = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=6).map(tuple)


def probability(pick, answer, radius=RADIUS, samples=20_000, seed=0) -> float:
    return success_probability(pick, answer, radius, samples=samples, generator=np.random.default_rng(seed))


@given(candidates, st.tuples(coordinate, coordinate), st.floats(0.1, 3), st.floats(0.1, 3))
def test_the_pick_is_a_fraction_of_its_candidates_and_grows_with_the_radius(points, answer, one, other):
    small, large = (probability(UniformPick(points), answer, radius) for radius in sorted((one, other)))
    assert 0 <= small <= large <= 1
    assert small * len(points) == pytest.approx(round(small * len(points)))


def test_the_pick_counts_every_candidate_within_the_radius():
    pick = UniformPick(((0.0, 0.0), (RADIUS, 0.0), (RADIUS + 1e-6, 0.0), (5.0, 5.0)))
    assert probability(pick, (0.0, 0.0)) == 0.5


@pytest.mark.parametrize("answer, share", [((0.0, 0.0), 1.0), ((5.0, 0.0), 0.5), ((5.0, 3.0), 0.25), ((9.0, 9.0), 0.0)])
def test_the_box_estimates_the_area_of_the_disc_in_it(answer, share):
    """A disc about the middle lies in the box whole, about a side by half, about a corner by a quarter."""
    box = UniformBox(-5.0, -3.0, 5.0, 3.0)
    assert probability(box, answer) == pytest.approx(share * pi * RADIUS**2 / 60, abs=4 * 0.5 / 20_000**0.5)
