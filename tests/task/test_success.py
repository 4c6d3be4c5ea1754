"""Eq. 4 and 5: success at a stop and its weighting by path length."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.settings.benchmark import Success
from ovman.task import Measurement, Relation, spl, success, visible

CONSTANTS = Success(radius_m=1.0, visible_px=100, sweep_deg=(0, 30, 60))
RELATIONS = st.sampled_from(Relation)
# Near the success radius, and on it.
DISTANCES = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 3.0))
PIXELS = st.one_of(st.sampled_from([0, 99, 100]), st.integers(0, 300))
MEASUREMENTS = st.builds(
    Measurement, DISTANCES, DISTANCES, DISTANCES, st.fixed_dictionaries(dict.fromkeys(CONSTANTS.sweep_deg, PIXELS))
)
LENGTHS = st.one_of(st.just(0.0), st.floats(0.0, 50.0))


@given(MEASUREMENTS, RELATIONS, DISTANCES, DISTANCES)
def test_success_is_monotone_in_the_radius(measurement, relation, a, b):
    near, far = (CONSTANTS.model_copy(update={"radius_m": radius}) for radius in sorted((a, b)))
    assert success(measurement, relation, near) <= success(measurement, relation, far)


@given(MEASUREMENTS, RELATIONS, PIXELS, PIXELS)
def test_success_is_monotone_in_the_visibility_threshold(measurement, relation, a, b):
    few, many = (CONSTANTS.model_copy(update={"visible_px": px}) for px in sorted((a, b)))
    assert success(measurement, relation, many) <= success(measurement, relation, few)


@given(MEASUREMENTS, RELATIONS, st.sampled_from(["box_distance_m", "answer_distance_m", "navigable_distance_m"]), DISTANCES)
def test_coming_closer_never_loses(measurement, relation, field, distance):
    nearer = replace(measurement, **{field: min(distance, getattr(measurement, field))})
    assert success(measurement, relation, CONSTANTS) <= success(nearer, relation, CONSTANTS)


@given(MEASUREMENTS, RELATIONS, DISTANCES, PIXELS)
def test_each_side_reads_its_own_terms_only(measurement, relation, distance, px):
    if relation.past:
        other = replace(measurement, box_distance_m=distance, visible_px=dict.fromkeys(CONSTANTS.sweep_deg, px))
    else:
        other = replace(measurement, answer_distance_m=distance)
    assert success(other, relation, CONSTANTS) == success(measurement, relation, CONSTANTS)


@pytest.mark.parametrize(
    ("box", "answer", "navigable", "px", "current", "past"),
    [
        (1.0, 9.0, 9.0, {0: 0, 30: 100, 60: 0}, True, False),
        (9.0, 9.0, 1.0, {0: 100, 30: 0, 60: 0}, True, True),
        (0.0, 1.0, 9.0, {0: 99, 30: 99, 60: 99}, False, True),
        (1.01, 1.01, 1.01, {0: 500, 30: 500, 60: 500}, False, False),
        (None, 0.5, 9.0, None, False, True),
        (None, 9.0, 0.5, None, False, True),
        (None, 9.0, 0.5, {0: 0, 30: 0, 60: 100}, True, True),
    ],
)
def test_success_follows_equation_4(box, answer, navigable, px, current, past):
    measurement = Measurement(box, answer, navigable, px)
    assert success(measurement, Relation.APPEARED, CONSTANTS) is current
    assert success(measurement, Relation.REMOVED, CONSTANTS) is past


def test_pitches_beside_the_sweep_do_not_count_and_those_of_it_must_be_there():
    assert not visible(Measurement(0.0, 0.0, 0.0, {0: 0, 30: 0, 60: 0, 45: 5000}), CONSTANTS)
    with pytest.raises(ValueError, match=r"needs the pitches \[60\]"):
        visible(Measurement(0.0, 0.0, 0.0, {0: 500, 30: 500}), CONSTANTS)


@pytest.mark.parametrize("field", ["box_distance_m", "answer_distance_m", "navigable_distance_m"])
@pytest.mark.parametrize("value", [-0.1, float("nan")])
def test_a_distance_is_a_number_and_not_negative(field, value):
    with pytest.raises(ValueError, match=field):
        replace(Measurement(0.0, 0.0, 0.0, None), **{field: value})


@given(st.booleans(), LENGTHS, LENGTHS)
def test_spl_lies_between_zero_and_success(succeeded, shortest, travelled):
    assert 0.0 <= spl(succeeded, shortest, travelled) <= succeeded


@given(LENGTHS, LENGTHS, LENGTHS)
def test_spl_never_rises_with_the_distance_travelled(shortest, a, b):
    short, long = sorted((a, b))
    assert spl(True, shortest, long) <= spl(True, shortest, short)


@given(LENGTHS, LENGTHS)
def test_a_path_no_longer_than_the_shortest_scores_one(shortest, saved):
    assert spl(True, shortest, max(0.0, shortest - saved)) == 1.0


def test_standing_at_the_answer_scores_the_success():
    assert spl(True, 0.0, 0.0) == 1.0
    assert spl(False, 0.0, 0.0) == 0.0
    assert spl(True, 0.0, 0.25) == 0.0
    assert spl(True, 2.0, 4.0) == 0.5


@pytest.mark.parametrize("lengths", [(-1.0, 0.0), (0.0, -1.0), (float("nan"), 1.0), (1.0, float("nan"))])
def test_a_length_is_a_number_and_not_negative(lengths):
    with pytest.raises(ValueError, match="at least 0"):
        spl(False, *lengths)
