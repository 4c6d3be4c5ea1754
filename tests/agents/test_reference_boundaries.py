"""The reference agent's stages on their thresholds, at ties, and with nothing to work on."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from ovman.agents.interface import Relation, UniformBox, UniformPick
from ovman.agents.reference.association import Association, associate, cost_matrix, distances, pad_costs, positions
from ovman.agents.reference.reasoning import (
    decide_by_last_sighting,
    decide_by_spread,
    ground,
    pick_grounded,
    pick_instance,
    similarities,
    spread_m,
)
from ovman.perception.object_map import ObjectMap

SCALE = 2.0
NAN = float("nan")


def at(answer) -> tuple[float, float]:
    return answer.x, answer.z


# --- association ----------------------------------------------------------------------------------


def test_a_pair_is_taken_up_to_the_gate_and_not_at_it():
    for gate_m in (0.001, 1.25, 40.0):
        near, far = [(0.0, 0.0)], [(np.nextafter(gate_m, 0.0), 0.0)]
        assert associate(near, far, gate_m=gate_m, feature_scale_m=SCALE).pairs == ((0, 0),)
        assert associate(near, [(gate_m, 0.0)], gate_m=gate_m, feature_scale_m=SCALE).pairs == ()
    # Here the solver pairs what costs as much as leaving both unmatched.
    assert associate([(0, 0)], [(1, 0), (0, 1)], gate_m=1.0, feature_scale_m=SCALE) == Association((), (0,), (0, 1))


def test_features_count_as_far_as_their_scale_says():
    """Orthogonal features cost feature_scale_m."""
    f_1, f_2 = [(1.0, 0.0)], [(0.0, 1.0)]
    at_gate = associate([(0, 0)], [(0, 0)], f_1, f_2, gate_m=SCALE, feature_scale_m=SCALE)
    assert at_gate.pairs == () and (at_gate.unmatched_1, at_gate.unmatched_2) == ((0,), (0,))
    assert associate([(0, 0)], [(0, 0)], f_1, f_2, gate_m=SCALE + 0.01, feature_scale_m=SCALE).pairs == ((0, 0),)
    assert cost_matrix(positions([(0, 3)]), positions([(4, 0)]), np.array(f_1), np.array(f_2), feature_scale_m=SCALE) == 7.0


def test_a_cost_is_never_below_the_distance():
    """The inner product of unit vectors in floating point may exceed one."""
    f = np.array([[1.0 + 1e-9, 0.0]])
    p = positions([(0, 0)])
    assert cost_matrix(p, p, f, f, feature_scale_m=SCALE) == 0.0


def test_the_distance_is_that_of_the_floor_plane():
    p_1, p_2 = positions([(1, 2), (-1, -2)]), positions([(4, 6), (1, 2), (-4, -6)])
    expected = [[math.dist(a, b) for b in p_2.tolist()] for a in p_1.tolist()]
    assert distances(p_1, p_2).tolist() == pytest.approx(np.array(expected))
    assert cost_matrix(p_1, p_2, feature_scale_m=SCALE).tolist() == distances(p_1, p_2).tolist()


@pytest.mark.parametrize("scale", [3.0, 0.7])
def test_what_is_given_in_single_precision_is_compared_in_double(scale):
    """Perception makes features of single precision. At a gate of the cost itself a pair is not taken, just above it is."""
    f_1, f_2 = np.array([[0.6, 0.8]], np.float32), np.array([[0.8, 0.6]], np.float32)
    unlike, p = np.array([[0.1]], np.float32), positions([(0, 0)])
    exactly = cost_matrix(p, p, f_1.astype(float), f_2.astype(float), feature_scale_m=scale).item()
    judged = cost_matrix(p, p, disagreement=unlike.astype(float), feature_scale_m=scale).item()
    for cost, given in ((exactly, {"f_1": f_1, "f_2": f_2}), (judged, {"disagreement": unlike})):
        assert associate(p, p, **given, gate_m=cost, feature_scale_m=scale).pairs == ()
        assert associate(p, p, **given, gate_m=float(np.nextafter(cost, 9.0)), feature_scale_m=scale).pairs == ((0, 0),)


@pytest.mark.parametrize("n, m", [(1, 1), (1, 4), (4, 1), (3, 3)])
@pytest.mark.parametrize("gate_m", [0.01, 1.25, 40.0])
def test_the_prohibitive_cost_exceeds_that_of_leaving_everything_unmatched(n, m, gate_m):
    square = pad_costs(np.zeros((n, m)), gate_m)
    off_diagonal = [square[:n, m:][~np.eye(n, dtype=bool)], square[n:, :m][~np.eye(m, dtype=bool)]]
    for cost in np.concatenate(off_diagonal).tolist():
        assert (n + m) * gate_m / 2 < cost < math.inf
    assert np.diag(square[:n, m:]).tolist() == [gate_m / 2] * n
    assert np.diag(square[n:, :m]).tolist() == [gate_m / 2] * m
    assert (square[n:, m:] == 0.0).all() and square.shape == (n + m, n + m)


def tied(p_1, p_2, f_1=None, f_2=None) -> list[tuple]:
    """The partners that are found, as pairs of (position, features)."""
    found = associate(p_1, p_2, f_1, f_2, gate_m=1.25, feature_scale_m=SCALE)
    return [((p_1[i], f_1 and f_1[i]), (p_2[j], f_2 and f_2[j])) for i, j in found.pairs]


def of_the_solver(p_1, p_2, f_1=None, f_2=None) -> list[tuple]:
    """The same from the solver alone, with the instances in the order of x, z, features."""
    one, two = (sorted(zip(p, f or [None] * len(p), strict=True)) for p, f in ((p_1, f_1), (p_2, f_2)))
    arrays = [np.array([f for _, f in visit]) if f_1 else None for visit in (one, two)]
    cost = cost_matrix(positions([p for p, _ in one]), positions([p for p, _ in two]), *arrays, feature_scale_m=SCALE)
    rows, columns = linear_sum_assignment(pad_costs(cost, 1.25))
    return [(one[i], two[j]) for i, j in zip(rows, columns, strict=True) if i < len(one) and j < len(two) and cost[i, j] < 1.25]


def test_among_equal_optima_that_of_the_lexicographic_order_is_taken():
    here = [(0.0, 0.0)]
    for around in itertools.permutations([(1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-1.0, 0.0)]):
        assert tied(here, around) == of_the_solver(here, around)
        assert tied(around, here) == of_the_solver(around, here)
    for around in itertools.permutations([(0.6, 0.8, 0.0), (0.6, -0.8, 0.0), (0.6, 0.0, 0.8)]):
        one, three = (here, here * 3), ([(1.0, 0.0, 0.0)], list(around))
        assert tied(*one, *three) == of_the_solver(*one, *three)
        assert tied(*reversed(one), *reversed(three)) == of_the_solver(*reversed(one), *reversed(three))


def test_pairs_and_unmatched_are_sorted():
    p_1, p_2 = [(5, 0), (0, 0), (9, 9), (-9, 9)], [(0, 0), (5, 0), (99, 0), (-99, 0)]
    assert associate(p_1, p_2, gate_m=1.25, feature_scale_m=SCALE) == Association(((0, 1), (1, 0)), (2, 3), (2, 3))


@pytest.mark.parametrize("name", ["p_1", "p_2", "f_1", "f_2"])
@pytest.mark.parametrize("wrong", ["shape", "count", "finite"])
def test_a_wrong_array_is_named(name, wrong):
    arrays = {"p_1": [(0, 0)], "p_2": [(0, 0)], "f_1": [(1.0, 0.0)], "f_2": [(1.0, 0.0)]}
    arrays[name] = {"shape": [0.5, 0.5], "count": [(0.0, 1.0, 0.0)] * 2, "finite": [(NAN, 0.0)]}[wrong]
    message = "holds a value that is not finite" if wrong == "finite" else "must have the shape"
    with pytest.raises(ValueError, match=f"^{name} {message}"):
        associate(*arrays.values(), gate_m=1.25, feature_scale_m=SCALE)


def test_features_of_one_visit_only_are_refused():
    for f_1, f_2 in (([(1.0,)], None), (None, [(1.0,)])):
        with pytest.raises(ValueError, match="both visits or for neither"):
            associate([(0, 0)], [(0, 0)], f_1, f_2, gate_m=1.25, feature_scale_m=SCALE)


def test_an_empty_visit_has_no_features_to_compare():
    for empty in ([], np.zeros((0, 2))):
        found = associate([], [(0, 0)], empty, [(1.0, 0.0)], gate_m=1.25, feature_scale_m=SCALE)
        assert found == Association((), (), (0,))
        found = associate([(0, 0)], [], [(1.0, 0.0)], empty, gate_m=1.25, feature_scale_m=SCALE)
        assert found == Association((), (0,), ())
    with pytest.raises(ValueError, match="f_1 must have the shape"):
        associate([(0, 0)], [(0, 0)], [], [(1.0, 0.0)], gate_m=1.25, feature_scale_m=SCALE)


def test_positions_are_pairs_of_finite_numbers():
    assert positions([]).shape == positions(np.zeros((0, 7))).shape == (0, 2)
    assert positions([(1, 2)]).dtype == np.float64
    for wrong in ([1.0, 2.0], [(1.0, 2.0, 3.0)], [[[1.0, 2.0]]], 3.0):
        with pytest.raises(ValueError, match=r"^positions must have the shape \(N, 2\)"):
            positions(wrong)
    with pytest.raises(ValueError, match="^here holds"):
        positions([(0.0, math.inf)], "here")


# --- MOVING ---------------------------------------------------------------------------------------


def test_the_spread_of_nothing_and_of_one_point_is_zero():
    assert spread_m([]) == spread_m([(3.0, 4.0)]) == 0.0
    assert spread_m([(0.0, 0.0), (3.0, 4.0), (3.0, 0.0)]) == 5.0


def test_of_equal_spreads_the_last_point_of_smallest_x_then_z_is_taken():
    """All tracks are one metre long; their first points, and those before the last, would be ordered otherwise."""
    tracks = [
        [(0.5, 0.0), (0.0, 0.0), (-1.0, 0.0)],
        [(-0.5, 8.0), (0.0, 8.0), (-1.0, 8.0)],
        [(0.5, -9.0), (-0.5, -9.0), (0.5, -9.0), (-0.4, -9.0)],
    ]
    for order in itertools.permutations(tracks):
        assert at(decide_by_spread(order, 0.4)) == (-1.0, 0.0)


def test_tracks_without_a_point_are_passed_over():
    assert at(decide_by_spread([[], [(0.0, 0.0), (1.0, 2.0)]], 0.4)) == (1.0, 2.0)
    assert decide_by_spread([[], []], 0.4).reason == "no_candidate"
    assert decide_by_spread([[(0.0, 0.0)]], 0.0).reason == "no_motion"


def test_a_wrong_track_is_named():
    association = Association((), (), (0,))
    for ask in (
        lambda t: decide_by_spread([t], 0.4),
        lambda t: decide_by_last_sighting([t], [0], association),
        lambda t: pick_instance(Relation.MOVING, [t], [(0.0, 0.0)]),
        spread_m,
    ):
        with pytest.raises(ValueError, match="^track must have"):
            ask([1.0, 2.0, 3.0])


def test_of_clusters_seen_last_in_one_view_that_of_smallest_x_then_z_is_taken():
    tracks = [[(9.0, 9.0), (0.0, 1.0)], [(-9.0, 0.0), (0.0, 2.0)], [(-8.0, 0.0), (1.0, 0.0)], [(-5.0, -5.0)]]
    for order in itertools.permutations(range(3)):
        some = [tracks[k] for k in (*order, 3)]
        assert at(decide_by_last_sighting(some, [7, 7, 7, 6], Association((), (), (0, 1, 2, 3)))) == (0.0, 1.0)
        assert at(decide_by_last_sighting(some, [7, 7, 7, 8], Association((), (), (0, 1, 2, 3)))) == (-5.0, -5.0)
        assert at(decide_by_last_sighting(some, [7, 7, 7, 8], Association(((0, 3),), (), (0, 1, 2)))) == (0.0, 1.0)


def test_a_single_visit_picks_places_and_for_moving_last_track_points():
    """Where a cluster lies is not where it was seen last."""
    track = np.array([[0.0, 0.0], [3.0, 4.0]])
    seen = ObjectMap(p=np.array([[1.0, 2.0], [9.0, 9.0]]), f=np.eye(2), tracks=(track, track), last_seen=(1, 1))
    for relation in Relation:
        outcome, evidence = pick_grounded(relation, seen, (0,), [(0.0, 1.0), (2.0, -1.0)])
        if relation.past:
            assert outcome == UniformBox(0.0, -1.0, 2.0, 1.0)
        else:
            assert outcome == UniformPick(((3.0, 4.0) if relation is Relation.MOVING else (1.0, 2.0),))
        assert (evidence.grounded_1, evidence.grounded_2) == (None, (0,))
        if relation.current:
            assert pick_grounded(relation, seen, (), [])[0].reason == "nothing_grounded"
        else:
            with pytest.raises(ValueError, match="reachable positions are empty"):
                pick_grounded(relation, seen, (), [])


# --- grounding ------------------------------------------------------------------------------------

UNIT = np.array([1.0, 0.0])
MAP = np.array([[0.5, 0.0], [0.25, 1.0], [0.75, 0.0], [0.5, 3.0]])
"""Similarities 0.5, 0.25, 0.75, 0.5: exact in binary."""


@pytest.mark.parametrize(
    "margin, means", [(0.0, (2,)), (0.2499, (2,)), (0.25, (0, 2, 3)), (0.4999, (0, 2, 3)), (0.5, (0, 1, 2, 3))]
)
def test_the_margin_of_the_grounding_is_inclusive(margin, means):
    assert ground(MAP, UNIT, margin) == means


def test_an_empty_map_of_any_shape_means_nothing():
    for empty in ([], np.zeros((0, 0)), np.zeros((0, 2))):
        assert ground(empty, UNIT, 0.1) == () and similarities(empty, UNIT).shape == (0,)


@pytest.mark.parametrize("margin", [-1e-9, NAN])
def test_a_margin_is_at_least_zero(margin):
    with pytest.raises(ValueError, match="similarity_margin must be at least 0"):
        ground(MAP, UNIT, margin)


@pytest.mark.parametrize("features, noun", [(MAP, [1.0]), (MAP, [[1.0, 0.0]]), ([1.0, 0.0], UNIT), (MAP[None], UNIT)])
def test_features_and_noun_are_of_one_encoder(features, noun):
    with pytest.raises(ValueError, match="of one encoder are needed"):
        similarities(features, noun)


@pytest.mark.parametrize("features, noun", [([[NAN, 0.0]], UNIT), (MAP, [NAN, 0.0]), ([[math.inf, 0.0]], [math.inf, 0.0])])
def test_what_is_not_finite_is_refused(features, noun):
    with pytest.raises(ValueError, match="not finite"):
        similarities(features, noun)
