"""Costs and gains of executing answers, an agent's own task, and how far movers go."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import settings

from ovman.analysis.navigation import AFTER, BETWEEN_VISITS, WALKS, WHILE_ACTING, mover_distances, navigation, own_task, rescued
from ovman.records.episode import Episode
from ovman.settings import Kind
from ovman.settings.arms import ArmJob
from tests.analysis.fabricated import embodied, named, over_all, static
from tests.task.test_episode import MOVED, moving

PROPERTY = settings(max_examples=20, derandomize=True, deadline=None)
RADIUS_M = 1.0
ARMS = {
    "answers": ArmJob(name="answers", kind=Kind.STATIC, agent="x:y"),
    "picks": ArmJob(name="picks", kind=Kind.STATIC, agent="x:y", expected=True),
    "driven": ArmJob(name="driven", kind=Kind.EMBODIED, agent="x:y", executes="answers"),
    "picked": ArmJob(name="picked", kind=Kind.EMBODIED, agent="x:y", executes="picks"),
    "alone": ArmJob(name="alone", kind=Kind.EMBODIED, agent="x:y"),
}


def test_an_expectation_has_no_successes_to_lose():
    outcomes = [static("picks", i, 0.25, "expected") for i in range(8)]
    (whole,) = over_all(navigation(outcomes, [embodied("picked", i, i == 0) for i in range(8)], ARMS, RADIUS_M))
    assert whole.static_successes == 2.0 and (whole.lost, whole.gained, whole.p) == (None, None, None)
    (whole,) = over_all(navigation(outcomes, [embodied("alone", i, True) for i in range(8)], ARMS, RADIUS_M))
    assert (whole.executes, whole.static_successes, whole.lost, whole.sr) == (None, None, None, 1.0)
    assert rescued(navigation(outcomes, [embodied(arm, 0, True) for arm in ("picked", "alone")], ARMS, RADIUS_M)) == []


def test_each_seed_has_its_rows_and_an_executed_arm_has_one_answer():
    outcomes = [static("answers", i, True) for i in range(6)]
    runs = [embodied("driven", i, i >= seed, seed) for seed in (0, 2) for i in range(6)]
    assert [(row.seed, row.lost) for row in over_all(navigation(outcomes, runs, ARMS, RADIUS_M))] == [(0, 0), (2, 2)]
    with pytest.raises(ValueError, match="answers has answers under several seeds"):
        navigation([static("answers", 0, 1, seed=seed) for seed in (0, 1)], runs[:1], ARMS, RADIUS_M)


@pytest.mark.parametrize(("box_m", "count"), [(RADIUS_M, 1), (math.nextafter(RADIUS_M, math.inf), 0)])
def test_a_stop_at_the_radius_itself_is_near_the_box(box_m, count):
    runs = [embodied("driven", 0, True, box_distance_m=box_m)]
    assert over_all(navigation([static("answers", 0, 0.0, distance_m=2.0)], runs, ARMS, RADIUS_M))[0].rescued == count


def test_an_own_task_is_judged_of_all_runs():
    outcomes = [embodied("cow", i, False, seed, own_success=i < seed) for seed in (2, 0, 1) for i in range(3)]
    assert [(row.seed, row.own_successes) for row in over_all(own_task(outcomes))] == [(0, 0), (1, 1), (2, 2)]
    with pytest.raises(ValueError, match="cow: 1 of 9 runs lack a verdict on its own task"):
        own_task([replace(outcomes[0], own_success=None), *outcomes[1:]])


def test_a_mover_is_an_actions_steps_away_at_most_and_never_off_its_floor():
    episode = Episode.from_json(moving())
    rows = named(mover_distances([episode, Episode.from_json(MOVED)], 1.0, 1.5))
    away = [row for row in rows if row.phase == WHILE_ACTING]
    assert [(row.actions, row.n) for row in away] == [(actions, WALKS) for actions in AFTER]
    for row in away:
        # The floor is 26 points in a row, of which the mover is at the 21st.
        assert 0.0 <= row.least_m <= row.median_m <= row.greatest_m <= min(0.1 * row.actions, 2.0) + 1e-9
        assert row.moved is None
    assert away[0].greatest_m == 0.0 and away[-1].median_m > 0.0
    assert named(mover_distances([episode], 1.0, 1.5)) == rows and mover_distances([Episode.from_json(MOVED)], 1.0, 1.5) == []


def test_between_the_visits_a_mover_is_displaced_as_the_worlds_say():
    episode = Episode.from_json(moving())
    metres = math.dist(episode.world_1[episode.target].position, episode.world_2[episode.target].position)
    for moved_m, moved in ((metres, 1), (math.nextafter(metres, math.inf), 0)):
        row, *_ = named(mover_distances([episode], 1.0, moved_m))
        assert (row.phase, row.n, row.actions, row.least_m, row.greatest_m) == (BETWEEN_VISITS, 1, None, metres, metres)
        assert (row.within, row.moved) == (float(metres <= 1.0), moved)
