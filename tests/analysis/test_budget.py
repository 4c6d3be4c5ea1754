from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.budget import ANSWER_GIVEN, budget
from ovman.analysis.difficulty import By, difficulty
from ovman.analysis.rates import Interval, static_rates
from ovman.analysis.significance import significance
from tests.analysis.fabricated import static
from tests.arms import CONFIG

RUNGS, PAIRS = CONFIG.comparisons.rungs, tuple(CONFIG.comparisons.pairs.values())
PROPERTY = settings(max_examples=12, derandomize=True, deadline=None)
BOOLEANS = st.lists(st.tuples(*[st.booleans()] * len(RUNGS)), min_size=1, max_size=24)


def steps_of(outcomes):
    return budget(static_rates(outcomes, 0.95), significance(outcomes, [], PAIRS)[0], RUNGS)


@PROPERTY
@given(BOOLEANS)
def test_the_gains_add_up_to_what_the_lowest_rung_lacks(successes):
    outcomes = [static(arm, i, hits[k]) for k, arm in enumerate(RUNGS) for i, hits in enumerate(successes)]
    steps = steps_of(outcomes)
    for relation in {step.relation for step in steps}:
        lowest, *others = [step for step in steps if step.relation == relation]
        assert [step.rung for step in (lowest, *others)] == [*RUNGS.values(), ANSWER_GIVEN]
        assert (lowest.gain, lowest.gained, lowest.lost, lowest.p) == (None, None, None, None)
        assert lowest.rate + sum(step.gain for step in others) == pytest.approx(1.0)
        below = lowest
        for step in others:
            assert step.successes == below.successes + step.gained - step.lost
            below = step
        assert below.successes == below.n and below.lost == 0 and below.low is None


def test_without_a_rung_there_is_no_budget():
    lowest, _, highest = RUNGS
    outcomes = [static(arm, i, True) for arm in (lowest, highest) for i in range(6)]
    assert steps_of(outcomes) == []


@PROPERTY
@given(st.lists(st.tuples(st.integers(2, 7), st.sampled_from((1, 7, 10, 201)), st.booleans()), min_size=1, max_size=40))
def test_groups_by_instances_and_by_scene_each_hold_every_episode_once(episodes):
    outcomes = [
        static(arm, i, success, outcome, instances=instances, scene=f"FloorPlan{scene}")
        for arm, outcome in (("single_visit", "expected"), ("two_visits", "answered"))
        for i, (instances, scene, success) in enumerate(episodes)
    ]
    rows = difficulty(outcomes, 0.95)
    for by in By:
        for arm, interval in (("single_visit", Interval.POISSON_BINOMIAL), ("two_visits", Interval.WILSON)):
            mine = [row for row in rows if row.by is by and row.arm == arm]
            assert sum(row.n for row in mine) == len(episodes) and all(row.interval is interval for row in mine)
            assert sum(row.successes for row in mine) == sum(success for *_, success in episodes)
    groups = list(dict.fromkeys(row.group for row in rows if row.by is By.INSTANCES))
    assert groups == sorted(groups) and set(groups) <= {"2", "3", "4+"}
    scenes = list(dict.fromkeys(int(row.group.removeprefix("FloorPlan")) for row in rows if row.by is By.SCENE))
    assert scenes == sorted(scenes)
