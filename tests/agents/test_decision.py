from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ovman.agents.interface import Abstention, AbstentionReason, Answer
from ovman.agents.reference.association import Association, associate
from ovman.agents.reference.reasoning import decide, decide_by_last_sighting, decide_by_spread, spread_m
from ovman.task import Relation

GATE, TAU, SPREAD, DELTA_MIN = 1.25, 0.75, 0.4, 1.5
CONSTANTS = {"tau_m": TAU, "track_spread_m": SPREAD}
PAST, STATIC = (Relation.FORMER, Relation.REMOVED), tuple(relation for relation in Relation if relation is not Relation.MOVING)

# Homes: instances of a category, some metres apart, as (x, z) in steps of 5 cm.
coordinate = st.integers(-80, 80).map(lambda step: step * 0.05)
homes = st.lists(st.tuples(coordinate, coordinate), min_size=0, max_size=5, unique=True)


def ask(relation, p_1, p_2, tracks_2=None):
    association = associate(p_1, p_2, gate_m=GATE, feature_scale_m=2.0)
    return decide(relation, p_1, p_2, association, tracks_2 or [[p] for p in p_2], **CONSTANTS)


def distance(a, b) -> float:
    return float(np.hypot(a[0] - b[0], a[1] - b[1]))


@given(homes, st.tuples(coordinate, coordinate), st.integers(0, 4))
def test_a_displacement_beyond_the_gate_is_found_under_exact_positions(home, place, index):
    """gamma < Delta_min: a displaced instance does not match its own visit-1 position, so both of its ends are the answers."""
    assume(home)
    before = home[index % len(home)]
    rest = [p for p in home if p != before]
    assume(distance(before, place) >= DELTA_MIN)
    # Neither end near another instance, which would compete for the match.
    assume(all(distance(p, place) >= GATE and distance(p, before) >= GATE for p in rest))
    p_1, p_2 = [*rest, before], [place, *rest]
    assert ask(Relation.MOVED, p_1, p_2) == Answer(*place)
    assert ask(Relation.FORMER, p_1, p_2) == Answer(*before)


@given(homes, st.tuples(coordinate, coordinate))
def test_what_comes_and_what_goes_mirror_each_other(home, place):
    assume(place not in home)
    arrival = ask(Relation.APPEARED, home, [*home, place])
    assert arrival == ask(Relation.REMOVED, [*home, place], home)
    assert arrival == Answer(*place)


@given(homes, homes, st.sampled_from(STATIC))
def test_answers_come_from_the_visit_of_the_relation(p_1, p_2, relation):
    answer = ask(relation, p_1, p_2)
    if isinstance(answer, Answer):
        assert (answer.x, answer.z) in (p_1 if relation in PAST else p_2)


@given(homes, homes, st.sampled_from(STATIC), st.randoms(use_true_random=False))
def test_order_of_the_instances_does_not_matter(p_1, p_2, relation, random):
    shuffled_1, shuffled_2 = list(p_1), list(p_2)
    random.shuffle(shuffled_1)
    random.shuffle(shuffled_2)
    assert ask(relation, p_1, p_2) == ask(relation, shuffled_1, shuffled_2)


@given(homes, homes)
def test_visits_swapped_swap_the_relations(p_1, p_2):
    assert ask(Relation.APPEARED, p_1, p_2) == ask(Relation.REMOVED, p_2, p_1)
    association = associate(p_1, p_2, gate_m=GATE, feature_scale_m=2.0)
    mirrored = Association(tuple(sorted((j, i) for i, j in association.pairs)), association.unmatched_2, association.unmatched_1)
    tracks = [[p] for p in p_1]
    assert decide(Relation.MOVED, p_1, p_2, association, [], **CONSTANTS) == decide(
        Relation.FORMER, p_2, p_1, mirrored, tracks, **CONSTANTS
    )


@given(homes)
def test_nothing_changed_is_no_change(home):
    assert ask(Relation.APPEARED, home, home) == Abstention(AbstentionReason.NO_CANDIDATE)
    assert ask(Relation.REMOVED, home, home) == Abstention(AbstentionReason.NO_CANDIDATE)
    expected = AbstentionReason.DISPLACEMENT_BELOW_TAU if home else AbstentionReason.NO_CANDIDATE
    assert ask(Relation.MOVED, home, home) == Abstention(expected)
    assert ask(Relation.FORMER, home, home) == Abstention(expected)


@pytest.mark.parametrize("relation", Relation)
def test_an_empty_home_abstains(relation):
    assert ask(relation, [], []) == Abstention(AbstentionReason.NO_CANDIDATE)


@given(homes.filter(lambda home: len(home) > 0))
def test_where_the_other_visit_shows_nothing_one_candidate_is_answered_and_several_are_not_told_apart(home):
    for relation, p_1, p_2 in (
        *((relation, [], home) for relation in (Relation.MOVED, Relation.APPEARED)),
        *((relation, home, []) for relation in (Relation.FORMER, Relation.REMOVED)),
    ):
        expected = Answer(*home[0]) if len(home) == 1 else Abstention(AbstentionReason.NO_COUNTERPART)
        assert ask(relation, p_1, p_2) == expected
        assert isinstance(ask(relation, p_2, p_1), Abstention)


def test_the_farthest_unmatched_instance_is_taken():
    p_1, p_2 = [(0.0, 0.0)], [(0.1, 0.0), (2.0, 0.0), (5.0, 0.0)]
    assert ask(Relation.APPEARED, p_1, p_2) == Answer(5.0, 0.0)
    assert ask(Relation.MOVED, p_1, p_2) == Answer(5.0, 0.0)


def test_matched_counterparts_count_in_the_distance_to_the_other_visit():
    """d is the distance to the whole grounded set of the other visit, its matched members included."""
    p_1 = [(0.0, 0.0), (10.0, 0.0)]
    p_2 = [(0.0, 0.0), (10.0, 0.0), (12.0, 0.0), (3.0, 0.0)]
    assert ask(Relation.APPEARED, p_1, p_2) == Answer(3.0, 0.0)


@pytest.mark.parametrize("shift, relation, expected", [
    (TAU, Relation.MOVED, Answer(4.0 + TAU, 0.0)),
    (TAU, Relation.FORMER, Answer(4.0, 0.0)),
    (TAU - 0.01, Relation.MOVED, Abstention(AbstentionReason.DISPLACEMENT_BELOW_TAU)),
    (TAU - 0.01, Relation.FORMER, Abstention(AbstentionReason.DISPLACEMENT_BELOW_TAU)),
])  # fmt: skip
def test_moved_and_former_fall_back_to_the_most_displaced_pair(shift, relation, expected):
    p_1, p_2 = [(0.0, 0.0), (4.0, 0.0)], [(0.1, 0.0), (4.0 + shift, 0.0)]
    assert ask(relation, p_1, p_2) == expected


def test_moved_does_not_fall_back_past_an_unmatched_instance():
    p_1, p_2 = [(0.0, 0.0)], [(1.0, 0.0), (9.0, 0.0)]
    assert ask(Relation.MOVED, p_1, p_2) == Answer(9.0, 0.0)
    assert ask(Relation.FORMER, p_1, p_2) == Answer(0.0, 0.0)


def test_appeared_and_removed_have_no_fallback():
    p_1, p_2 = [(0.0, 0.0)], [(1.0, 0.0)]
    assert ask(Relation.APPEARED, p_1, p_2) == Abstention(AbstentionReason.NO_CANDIDATE)
    assert ask(Relation.REMOVED, p_1, p_2) == Abstention(AbstentionReason.NO_CANDIDATE)


def test_stable_answers_the_steadiest_pair_below_tau_only():
    assert ask(Relation.STABLE, [(0.0, 0.0), (4.0, 0.0)], [(0.3, 0.0), (4.1, 0.0)]) == Answer(4.1, 0.0)
    assert ask(Relation.STABLE, [(0.0, 0.0)], [(TAU, 0.0)]) == Abstention(AbstentionReason.DISPLACEMENT_ABOVE_TAU)
    assert ask(Relation.STABLE, [(0.0, 0.0)], [(9.0, 0.0)]) == Abstention(AbstentionReason.NO_CANDIDATE)


def test_moving_takes_the_largest_spread_and_its_last_point():
    still, slow, fast = [(0.0, 0.0)] * 3, [(1.0, 0.0), (1.5, 0.0)], [(5.0, 0.0), (5.0, 2.0), (5.0, 1.0)]
    assert decide_by_spread([still, slow, fast], SPREAD) == Answer(5.0, 1.0)
    assert ask(Relation.MOVING, [(0.0, 0.0)], [(0.0, 0.0), (5.0, 1.0)], [still, fast]) == Answer(5.0, 1.0)


@pytest.mark.parametrize("spread, moves", [(SPREAD, False), (SPREAD + 1e-6, True)])
def test_the_spread_must_exceed_its_threshold(spread, moves):
    answer = decide_by_spread([[(0.0, 0.0), (spread, 0.0)]], SPREAD)
    assert answer == (Answer(spread, 0.0) if moves else Abstention(AbstentionReason.NO_MOTION))


@given(st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=6), st.randoms(use_true_random=False))
def test_spread_is_that_of_the_set_and_at_most_the_path(track, random):
    shuffled = list(track)
    random.shuffle(shuffled)
    assert spread_m(track) == spread_m(shuffled)
    assert spread_m(track) <= sum(distance(a, b) for a, b in zip(track, track[1:], strict=False)) + 1e-9


def test_under_perception_moving_is_the_unmatched_cluster_seen_last():
    association = Association(((0, 1),), (), (0, 2))
    tracks = [[(0.0, 0.0), (1.0, 0.0)], [(7.0, 7.0)], [(2.0, 0.0), (3.0, 0.0)]]
    assert decide_by_last_sighting(tracks, [5, 23, 9], association) == Answer(3.0, 0.0)
    assert decide_by_last_sighting(tracks, [9, 23, 5], association) == Answer(1.0, 0.0)
    everything_matched = Association(((0, 0),), (), ())
    assert decide_by_last_sighting(tracks[:1], [3], everything_matched) == Abstention(AbstentionReason.NO_CANDIDATE)
