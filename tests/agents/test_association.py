"""Association: the cheapest partial matching by brute force, its gate, ties and inputs."""

from __future__ import annotations

import math
from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ovman.agents.reference.association import Association, associate, cost_matrix, distances, positions

GATE, SCALE = 1.25, 2.0


def points(largest: int = 4) -> st.SearchStrategy[np.ndarray]:
    """Positions within two gates of each other; a coarse lattice as often as not, for exact ties and exact gates."""
    fine = st.floats(-1.5, 1.5, allow_subnormal=False).map(lambda value: round(value, 4))
    coarse = st.integers(-6, 6).map(lambda step: step * 0.25)
    return st.integers(0, largest).flatmap(
        lambda n: st.one_of(arrays(np.float64, (n, 2), elements=fine), arrays(np.float64, (n, 2), elements=coarse))
    )


def unit_features(count: int, seed: int) -> np.ndarray:
    features = np.random.default_rng(seed).normal(size=(count, 3))
    return features / np.linalg.norm(features, axis=1, keepdims=True)


def total_cost(cost: np.ndarray, pairs: tuple[tuple[int, int], ...], gate_m: float) -> float:
    """Cost of a partial matching by its definition: its pairs, and half a gate for each instance that is left unmatched."""
    n, m = cost.shape
    return sum(cost[i, j] for i, j in pairs) + (n + m - 2 * len(pairs)) * gate_m / 2


def cheapest_by_enumeration(cost: np.ndarray, gate_m: float) -> float:
    n, m = cost.shape
    return min(
        total_cost(cost, tuple(zip(rows, columns, strict=True)), gate_m)
        for size in range(min(n, m) + 1)
        for rows in combinations(range(n), size)
        for columns in permutations(range(m), size)
    )


def close(p_1, p_2, f_1=None, f_2=None, gate_m=GATE, **kinds) -> Association:
    return associate(p_1, p_2, f_1, f_2, gate_m=gate_m, feature_scale_m=SCALE, **kinds)


@given(points(), points(), st.booleans(), st.integers(0, 99), st.sampled_from([0.25, GATE, 3.0]))
def test_the_matching_is_the_cheapest_of_all_partial_ones_and_has_every_instance_once(p_1, p_2, with_features, seed, gate_m):
    f_1, f_2 = (unit_features(len(p_1), seed), unit_features(len(p_2), seed + 1)) if with_features else (None, None)
    association = close(p_1, p_2, f_1, f_2, gate_m)
    cost = cost_matrix(p_1, p_2, f_1, f_2, feature_scale_m=SCALE)
    assert total_cost(cost, association.pairs, gate_m) == pytest.approx(cheapest_by_enumeration(cost, gate_m), abs=1e-9)
    assert all(cost[i, j] < gate_m for i, j in association.pairs)
    assert sorted([i for i, _ in association.pairs] + list(association.unmatched_1)) == list(range(len(p_1)))
    assert sorted([j for _, j in association.pairs] + list(association.unmatched_2)) == list(range(len(p_2)))
    for tuples in (association.pairs, association.unmatched_1, association.unmatched_2):
        assert tuples == tuple(sorted(tuples))


@given(points(6), points(6), st.randoms(use_true_random=False))
def test_order_of_the_instances_does_not_matter_even_under_ties(p_1, p_2, random):
    order_1, order_2 = random.sample(range(len(p_1)), len(p_1)), random.sample(range(len(p_2)), len(p_2))

    def matched(a: np.ndarray, b: np.ndarray) -> list[tuple[float, ...]]:
        return sorted((*a[i], *b[j]) for i, j in close(a, b).pairs)

    assert matched(p_1, p_2) == matched(p_1[order_1], p_2[order_2])


@pytest.mark.parametrize("gate_m", [0.001, GATE, 40.0])
def test_a_pair_is_taken_up_to_the_gate_and_not_at_it(gate_m):
    assert close([(0, 0)], [(np.nextafter(gate_m, 0.0), 0)], gate_m=gate_m).pairs == ((0, 0),)
    # Here the solver pairs what costs as much as leaving both unmatched.
    assert close([(0, 0)], [(gate_m, 0), (0, gate_m)], gate_m=gate_m) == Association((), (0,), (0, 1))


def test_feature_disagreement_is_converted_into_metres_and_never_negative():
    f_1, f_2 = np.array([(1.0, 0.0)]), np.array([(0.0, 1.0)])
    assert cost_matrix(positions([(0, 3)]), positions([(4, 0)]), f_1, f_2, feature_scale_m=SCALE) == 5.0 + SCALE
    half = [np.array([one], np.float32) for one in ((0.6, 0.8), (0.8, 0.6))]  # single precision is compared in double
    cost = SCALE * (1.0 - half[0].astype(float) @ half[1].astype(float).T).item()
    assert [close([(0, 0)], [(0, 0)], *half, gate_m=gate).pairs for gate in (cost, np.nextafter(cost, 9.0))] == [(), ((0, 0),)]
    long = np.array([[1.0 + 1e-9, 0.0]])  # the inner product of unit vectors in floating point may exceed one
    assert cost_matrix(positions([(0, 0)]), positions([(0, 0)]), long, long, feature_scale_m=SCALE) == 0.0


@given(points(), points(), st.integers(0, 99))
def test_a_disagreement_replaces_that_of_the_features(p_1, p_2, seed):
    f_1, f_2 = unit_features(len(p_1), seed), unit_features(len(p_2), seed + 1)
    same = np.clip(1.0 - f_1 @ f_2.T, 0.0, None)
    assert close(p_1, p_2, f_1, f_2, disagreement=same) == close(p_1, p_2, f_1, f_2)
    assert close(p_1, p_2, f_1, f_2, disagreement=np.full(same.shape, GATE / SCALE)).pairs == ()


def test_the_distance_is_that_of_the_floor_plane():
    p_1, p_2 = positions([(1, 2), (-1, -2)]), positions([(4, 6), (1, 2), (-4, -6)])
    assert distances(p_1, p_2) == pytest.approx(np.array([[math.dist(a, b) for b in p_2] for a in p_1]))


def test_positions_are_pairs_of_finite_numbers():
    with pytest.raises(ValueError, match="^p_2 holds a value that is not finite"):
        close([(0, 0)], [(0, math.nan)])
    assert positions([]).shape == positions(np.zeros((0, 7))).shape == (0, 2) and positions([(1, 2)]).dtype == np.float64
    for wrong in ([1.0, 2.0], [(1.0, 2.0, 3.0)], [[[1.0, 2.0]]], 3.0):
        with pytest.raises(ValueError, match=r"^positions must have the shape \(N, 2\)"):
            positions(wrong)
