"""Stops that are accepted beside the target's box, though the predicted point fails."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis.rescued import Rescued, rescued
from tests.analysis.fabricated import static

ARMS = [SimpleNamespace(name="drives", executes="answers"), SimpleNamespace(name="picks", executes="pick")]
ARMS.append(SimpleNamespace(name="alone", executes=None))
RADIUS = 1.0


def run(number, success, box_m, arm="drives", seed=0):
    return SimpleNamespace(
        episode=static("answers", number, 0.0).episode, arm=arm, seed=seed, success=success, box_distance_m=box_m
    )


drawn = st.lists(
    st.tuples(st.booleans(), st.floats(1.01, 5.0), st.booleans(), st.one_of(st.none(), st.floats(0, 3))), min_size=1, max_size=12
)


@given(drawn)
def test_the_rescued_are_gained_and_stand_beside_the_box(cases):
    answers = [static("answers", k, one[0], distance_m=0.5 if one[0] else one[1]) for k, one in enumerate(cases)]
    rows = rescued(answers, [run(k, one[2], one[3]) for k, one in enumerate(cases)], ARMS, RADIUS)
    *relations, whole = rows
    gained = [one for one in cases if one[2] and not one[0]]
    beside = [one for one in gained if one[3] is not None and one[3] <= RADIUS]
    assert (whole.relation, whole.n, whole.gained, whole.rescued) == ("all", len(cases), len(gained), len(beside))
    assert whole.nearest_m == min((one[1] for one in beside), default=None)
    assert whole.farthest_m == max((one[1] for one in beside), default=None)
    assert sum(row.rescued for row in relations) == whole.rescued and sum(row.n for row in relations) == whole.n


@pytest.mark.parametrize(("box_m", "beside"), [(RADIUS, 1), (math.nextafter(RADIUS, math.inf), 0)])
def test_a_stop_at_the_radius_itself_is_beside_the_box(box_m, beside):
    answers = [static("answers", 0, 0.0, distance_m=2.0)]
    assert [row.rescued for row in rescued(answers, [run(0, True, box_m)], ARMS, RADIUS)] == [beside, beside]


def test_a_pick_and_an_arm_that_executes_nothing_have_no_rows():
    picked = [static("pick", 0, 0.3, "expected")]
    assert rescued(picked, [run(0, True, 0.1, "picks"), run(0, True, 0.1, "alone")], ARMS, RADIUS) == []


def test_every_seed_has_its_rows():
    answers = [static("answers", 0, 0.0, distance_m=2.0)]
    rows = rescued(answers, [run(0, True, 0.9, seed=seed) for seed in (1, 0)], ARMS, RADIUS)
    assert [(row.seed, row.relation, row.rescued) for row in rows] == [
        (0, "moved", 1),
        (0, "all", 1),
        (1, "moved", 1),
        (1, "all", 1),
    ]


def test_arms_without_answers_that_are_realised_hide_no_others():
    arms = [*ARMS[1:], SimpleNamespace(name="waits", executes="nobody"), ARMS[0]]
    answers = [static("pick", 0, 0.3, "expected"), static("answers", 0, 0.0, distance_m=2.0)]
    runs = [run(0, True, 0.1, arm.name) for arm in arms]
    assert rescued(answers, runs, arms, RADIUS) == [
        Rescued("drives", "answers", 0, relation, 1, 1, 1, 2.0, 2.0) for relation in ("moved", "all")
    ]
