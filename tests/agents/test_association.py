from __future__ import annotations

from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ovman.agents.reference.association import Association, associate, cost_matrix, pad_costs

GATE = 1.25
SCALE = 2.0


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


def total_cost(cost: np.ndarray, pairs: tuple[tuple[int, int], ...]) -> float:
    """What a partial matching costs by its definition: its pairs, and half a gate for each that is left unmatched."""
    n, m = cost.shape
    return sum(cost[i, j] for i, j in pairs) + (n + m - 2 * len(pairs)) * GATE / 2


def cheapest_by_enumeration(cost: np.ndarray) -> float:
    n, m = cost.shape
    return min(
        total_cost(cost, tuple(zip(rows, columns, strict=True)))
        for size in range(min(n, m) + 1)
        for rows in combinations(range(n), size)
        for columns in permutations(range(m), size)
    )


def close(p_1, p_2, f_1=None, f_2=None) -> Association:
    return associate(p_1, p_2, f_1, f_2, gate_m=GATE, feature_scale_m=SCALE)


@given(points(), points(), st.booleans(), st.integers(0, 99))
def test_padding_finds_the_cheapest_of_all_partial_matchings(p_1, p_2, with_features, seed):
    f_1, f_2 = (unit_features(len(p_1), seed), unit_features(len(p_2), seed + 1)) if with_features else (None, None)
    association = close(p_1, p_2, f_1, f_2)
    cost = cost_matrix(p_1, p_2, f_1, f_2, feature_scale_m=SCALE)
    assert total_cost(cost, association.pairs) == pytest.approx(cheapest_by_enumeration(cost), abs=1e-9)
    assert all(cost[i, j] < GATE for i, j in association.pairs)


@given(points(7), points(7))
def test_every_instance_is_in_one_pair_or_unmatched(p_1, p_2):
    association = close(p_1, p_2)
    assert sorted([i for i, _ in association.pairs] + list(association.unmatched_1)) == list(range(len(p_1)))
    assert sorted([j for _, j in association.pairs] + list(association.unmatched_2)) == list(range(len(p_2)))
    assert association.pairs == tuple(sorted(association.pairs))
    assert association.unmatched_1 == tuple(sorted(association.unmatched_1))


@given(points(6), points(6), st.randoms(use_true_random=False))
def test_order_of_the_instances_does_not_matter_even_under_ties(p_1, p_2, random):
    order_1, order_2 = list(range(len(p_1))), list(range(len(p_2)))
    random.shuffle(order_1)
    random.shuffle(order_2)

    def matched(association: Association, a: np.ndarray, b: np.ndarray) -> list[tuple[float, ...]]:
        return sorted((*a[i], *b[j]) for i, j in association.pairs)

    shuffled_1, shuffled_2 = p_1[order_1], p_2[order_2]
    assert matched(close(p_1, p_2), p_1, p_2) == matched(close(shuffled_1, shuffled_2), shuffled_1, shuffled_2)


@given(points(5), points(5), st.floats(0.05, 1.2), st.floats(0.05, 1.2))
def test_a_wider_gate_never_leaves_more_unmatched(p_1, p_2, one, other):
    narrow, wide = sorted((one, other))
    associations = [associate(p_1, p_2, gate_m=gate, feature_scale_m=SCALE) for gate in (narrow, wide)]
    assert len(associations[0].pairs) <= len(associations[1].pairs)


@given(points(5), points(5))
def test_swapping_the_visits_costs_the_same(p_1, p_2):
    cost = cost_matrix(p_1, p_2, feature_scale_m=SCALE)
    assert total_cost(cost, close(p_1, p_2).pairs) == pytest.approx(total_cost(cost.T, close(p_2, p_1).pairs), abs=1e-9)


@given(points(5))
def test_an_unchanged_visit_is_matched_at_no_displacement(p):
    association = close(p, p)
    assert len(association.pairs) == len(p)
    assert all(np.array_equal(p[i], p[j]) for i, j in association.pairs)


@pytest.mark.parametrize("n, m", [(0, 0), (0, 3), (3, 0)])
def test_an_empty_visit_leaves_the_other_unmatched(n, m):
    p_1, p_2 = [(0.0, float(i)) for i in range(n)], [(0.0, float(j)) for j in range(m)]
    assert close(p_1, p_2) == Association((), tuple(range(n)), tuple(range(m)))
    assert close(p_1, p_2, unit_features(n, 0), unit_features(m, 1)) == Association((), tuple(range(n)), tuple(range(m)))


def test_the_gate_itself_is_not_paired():
    assert close([(0, 0)], [(GATE, 0)]).pairs == ()
    assert close([(0, 0)], [(GATE - 1e-6, 0)]).pairs == ((0, 0),)


def test_eligible_edges_compete():
    """The nearer pair of the middle one wins, and the other, though below the gate, is left unmatched."""
    assert close([(0.0, 0), (1.0, 0)], [(0.6, 0)]) == Association(((1, 0),), (0,), ())


def test_feature_disagreement_is_converted_into_metres():
    same, opposite = [(1.0, 0.0)], [(-1.0, 0.0)]
    assert close([(0, 0)], [(0.5, 0)], same, same).pairs == ((0, 0),)
    assert close([(0, 0)], [(0.5, 0)], same, opposite).pairs == ()
    cost = cost_matrix(np.zeros((1, 2)), np.array([[0.5, 0.0]]), np.array(same), np.array(opposite), feature_scale_m=SCALE)
    assert cost[0, 0] == pytest.approx(0.5 + SCALE * 2)


def test_padded_matrix_has_the_blocks_of_the_equation():
    square = pad_costs(np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]), GATE)
    assert square.shape == (5, 5)
    assert np.array_equal(np.diag(square[:2, 3:]), [GATE / 2] * 2)
    assert np.array_equal(np.diag(square[2:, :3]), [GATE / 2] * 3)
    assert np.array_equal(square[2:, 3:], np.zeros((3, 2)))
    elsewhere = np.concatenate([square[:2, 3:][~np.eye(2, dtype=bool)], square[2:, :3][~np.eye(3, dtype=bool)]])
    assert np.isfinite(elsewhere).all()
    assert (elsewhere > 5 * GATE / 2).all()


@pytest.mark.parametrize(
    "arguments, message",
    [
        (([(0, 0, 0)], [(0, 0)]), "p_1 must have the shape"),
        (([(0, 0)], [(0, float("nan"))]), "p_2 holds a value that is not finite"),
        (([(0, 0)], [(0, 0)], [(1, 0)]), "both visits or for neither"),
        (([(0, 0)], [(0, 0)], [(1, 0), (0, 1)], [(1, 0)]), "f_1 must have the shape"),
    ],
)
def test_wrong_input_is_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        close(*arguments)


def test_a_gate_is_positive():
    with pytest.raises(ValueError, match="gate_m"):
        associate([(0, 0)], [(0, 0)], gate_m=0.0, feature_scale_m=SCALE)


@given(points(), points(), st.integers(0, 99))
def test_a_disagreement_stands_for_that_of_the_features(p_1, p_2, seed):
    f_1, f_2 = unit_features(len(p_1), seed), unit_features(len(p_2), seed + 1)
    same = np.clip(1.0 - f_1 @ f_2.T, 0.0, None)
    given_ = associate(p_1, p_2, f_1, f_2, gate_m=GATE, feature_scale_m=SCALE, disagreement=same)
    assert given_ == close(p_1, p_2, f_1, f_2)
    far = np.full((len(p_1), len(p_2)), GATE / SCALE)
    assert associate(p_1, p_2, f_1, f_2, gate_m=GATE, feature_scale_m=SCALE, disagreement=far).pairs == ()


@pytest.mark.parametrize(("disagreement", "says"), [([[0.0, 1.0]], "shape"), ([[-0.1]], "below 0"), ([[np.nan]], "not finite")])
def test_a_disagreement_that_is_none_is_refused(disagreement, says):
    with pytest.raises(ValueError, match=says):
        associate([(0, 0)], [(0, 0)], gate_m=GATE, feature_scale_m=SCALE, disagreement=disagreement)
