"""Success by scene, seed, difficulty, failure, rung and reading of oracles, and next to the chance of 1/n."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.breakdowns import (
    ANSWER_GIVEN,
    INSTANCES,
    LOST,
    OWN,
    POSITIONS,
    Verdict,
    budget,
    difficulty,
    judge_failure,
    readings,
    seed_rates,
    shortcuts,
    taxonomy,
)
from ovman.analysis.comparisons import significance
from ovman.analysis.navigation import navigation
from ovman.analysis.outcomes import static_outcomes
from ovman.analysis.rates import Interval, arm_rates
from ovman.analysis.statistics import mcnemar_exact, wilson_interval
from ovman.records.episode import Episode
from ovman.records.prediction import Answer, Prediction
from ovman.settings import Kind, Reading
from ovman.settings.arms import ArmJob
from tests.analysis.fabricated import embodied, named, over_all, static
from tests.analysis.test_rates import RUNS, runs_of
from tests.arms import CONFIG
from tests.episodes import TARGET, episode_record

PROPERTY = settings(max_examples=15, derandomize=True, deadline=None)
R, NEAR = 1.0, 2.0
POINT = st.tuples(*[st.floats(-4, 4).map(lambda value: round(value, 2))] * 2)

# --- seeds, scenes, difficulty ------------------------------------------------------------------------


@PROPERTY
@given(RUNS)
def test_the_passes_of_an_arm_are_those_that_its_rate_is_the_mean_of(runs):
    whole = over_all(seed_rates([*runs_of("several", runs), static("once", 0, 1)], 0.95))
    assert [(row.arm, row.seed) for row in whole] == ([("several", n) for n in range(len(runs))] if len(runs) > 1 else [])
    rate = arm_rates(runs_of("several", runs), 0.95)[-1]
    if whole:
        assert sum(row.rate for row in whole) / len(whole) == pytest.approx(rate.rate)
    assert [row.kind for row in named(seed_rates([embodied("cow", 0, True)], 0.95))] == [Kind.EMBODIED] * 2


@PROPERTY
@given(st.lists(st.tuples(st.integers(2, 7), st.sampled_from((1, 7, 10, 201)), st.booleans()), min_size=1, max_size=40))
def test_groups_of_difficulty_hold_every_episode_once(episodes):
    outcomes = [
        static(arm, i, success, outcome, instances=instances, scene=f"FloorPlan{scene}")
        for arm, outcome in (("picks", "expected"), ("answers", "answered"))
        for i, (instances, scene, success) in enumerate(episodes)
    ]
    rows = named(difficulty(outcomes, 0.95))
    for by in ("instances", "scene"):
        for arm, interval in (("picks", Interval.POISSON_BINOMIAL), ("answers", Interval.WILSON)):
            mine = [row for row in rows if row.by == by and row.arm == arm]
            assert sum(row.n for row in mine) == len(episodes) and all(row.interval is interval for row in mine)
    groups = list(dict.fromkeys(row.group for row in rows if row.by == INSTANCES))
    assert groups == sorted(groups) and set(groups) <= {"2", "3", "4+"}


# --- the chance of 1/n --------------------------------------------------------------------------------


def test_a_neighbour_at_the_radius_makes_an_episode_crowded():
    near = [R, math.nextafter(R, math.inf), None, math.nextafter(R, math.inf)]
    answers = [static("answers", 6 * k, k < 2, instances=2 + 2 * (k % 2), neighbour_m=m) for k, m in enumerate(near)]
    (row,) = over_all(shortcuts(answers, R))
    assert (row.n, row.chance, row.rate, row.excess) == (4, 0.375, 0.5, 0.125)
    assert (row.crowded, row.crowded_rate, row.uncrowded_rate) == (1, 1.0, pytest.approx(1 / 3))
    (row,) = over_all(shortcuts([embodied("drives", k, False, seed) for k in range(2) for seed in (0, 1)], R))
    assert (row.kind, row.n, row.crowded, row.crowded_rate, row.uncrowded_rate) == (Kind.EMBODIED, 2, 0, None, 0.0)


# --- failures -----------------------------------------------------------------------------------------


def judge(relation, target, others, outcome):
    """Judge one answer. The queried object is at `target`."""
    names = (TARGET, *(f"other {k}" for k in range(len(others))))
    world = [{"id": k, "category": "Chair", "x": x, "z": z} for k, (x, z) in zip(names, (target, *others), strict=True)]
    episode = Episode.from_json(episode_record(relation, answer=target, world=world))
    (row,) = static_outcomes([episode], [Prediction.of(episode.id, "two_visits", 0, outcome)], radius_m=R, samples=10, seed=0)
    return judge_failure(row, R, NEAR)


@given(st.sampled_from(["moved", "former", "removed"]), POINT, st.lists(POINT, max_size=4), POINT)
def test_the_verdict_follows_from_the_distances(relation, target, others, predicted):
    def distance(where):
        return ((where[0] - predicted[0]) ** 2 + (where[1] - predicted[1]) ** 2) ** 0.5

    got = judge(relation, target, others, Answer(*predicted))
    if distance(target) <= R:
        assert got is Verdict.SUCCESS
    elif any(distance(other) <= R for other in others):
        assert got is Verdict.WRONG_INSTANCE
    else:
        assert got is (Verdict.NEAR_MISS if distance(target) <= NEAR else Verdict.ELSEWHERE)


@pytest.mark.parametrize(
    ("distance_m", "other_m", "expected"),
    [
        (9.0, R, Verdict.WRONG_INSTANCE),
        (1.5, math.nextafter(R, 2.0), Verdict.NEAR_MISS),
        (9.0, 0.0, Verdict.WRONG_INSTANCE),
        (NEAR, None, Verdict.NEAR_MISS),
        (math.nextafter(NEAR, 3.0), None, Verdict.ELSEWHERE),
    ],
)
def test_the_distances_of_the_taxonomy_are_inclusive(distance_m, other_m, expected):
    assert judge_failure(static("arm", 0, 0, distance_m=distance_m, other_m=other_m), R, NEAR) is expected


@PROPERTY
@given(RUNS)
def test_the_verdicts_of_each_run_are_a_partition(runs):
    rows = named(taxonomy(runs_of("arm", runs) + [static("pick", 0, 0.5, "expected")], [], R, NEAR))
    marks = list(range(len(runs))) if len(runs) > 1 else [None]
    assert {row.arm for row in rows} == {"arm"} and list(dict.fromkeys(row.seed for row in rows)) == marks
    for mark, run in zip(marks, runs, strict=True):
        for relation in {row.relation for row in rows}:
            of = [row for row in rows if (row.seed, row.relation) == (mark, relation)]
            assert [row.verdict for row in of] == [*Verdict] and {row.n for row in of} == {sum(row.episodes for row in of)}
        whole = {row.verdict: row.episodes for row in rows if (row.seed, row.relation) == (mark, "all")}
        assert whole["success"] == sum(run)


@PROPERTY
@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), min_size=1, max_size=30))
def test_navigation_loses_a_subset_of_the_successes(episodes):
    arms = {"drives": ArmJob(name="drives", kind=Kind.EMBODIED, agent="x:y", executes="answers")}
    outcomes = [static("answers", i, answered) for i, (answered, *_) in enumerate(episodes)]
    runs = [embodied("drives", i, run[seed], seed) for seed in (0, 1) for i, (_, *run) in enumerate(episodes)]
    rows = over_all(taxonomy(outcomes, navigation(outcomes, runs, arms, R), R, NEAR))
    lost = {row.seed: row.episodes for row in rows if row.verdict == LOST}
    assert lost == {seed: sum(answered and not run[seed] for answered, *run in episodes) for seed in (0, 1)}


# --- the error budget and readings ----------------------------------------------------------------------

RUNGS, PAIRS = CONFIG.comparisons.rungs, tuple(CONFIG.comparisons.pairs.values())


def steps_of(outcomes):
    return named(budget(arm_rates(outcomes, 0.95), significance(outcomes, PAIRS), RUNGS))


@PROPERTY
@given(st.lists(st.tuples(*[st.booleans()] * len(RUNGS)), min_size=1, max_size=24))
def test_the_gains_add_up_to_what_the_lowest_rung_lacks(successes):
    steps = steps_of([static(arm, i, hits[k]) for k, arm in enumerate(RUNGS) for i, hits in enumerate(successes)])
    for relation in {step.relation for step in steps}:
        lowest, *others = [step for step in steps if step.relation == relation]
        assert [step.rung for step in (lowest, *others)] == [*RUNGS.values(), ANSWER_GIVEN]
        assert (lowest.gain, lowest.gained, lowest.lost, lowest.p) == (None, None, None, None)
        assert lowest.rate + sum(step.gain for step in others) == pytest.approx(1.0)
        below = lowest
        for step in others:
            assert step.successes == below.successes + step.gained - step.lost and step.p <= 1.0
            below = step
        assert below.successes == below.n and (below.lost, below.low) == (0, None)
        assert below.p == mcnemar_exact(below.gained, 0)


def test_without_a_rung_there_is_no_budget():
    lowest, _, highest = RUNGS
    assert steps_of([static(arm, i, True) for arm in (lowest, highest) for i in range(6)]) == []


MAPS = CONFIG.comparisons.readings
OURS = [name for name, title in MAPS.items() if title == next(iter(MAPS.values()))]


@PROPERTY
@given(st.lists(st.tuples(*[st.booleans()] * len(OURS)), min_size=1, max_size=20))
def test_gains_and_losses_are_against_the_first_arm_of_the_map(hits):
    outcomes = [static(name, i, row[k]) for k, name in enumerate(OURS) for i, row in enumerate(hits)]
    rows = {row.arm: row for row in over_all(readings(outcomes, CONFIG.arms, MAPS, 0.95))}
    own = rows[OURS[0]]
    assert (own.gained, own.lost, own.p, own.grounding) == (None, None, None, OWN)
    for name in OURS[1:]:
        assert rows[name].successes == own.successes + rows[name].gained - rows[name].lost and 0 < rows[name].p <= 1
        assert (rows[name].low, rows[name].high) == wilson_interval(rows[name].successes, len(hits), 0.95)
    assert [rows[name].grounding for name in OURS] == [OWN, *Reading]


def test_expectations_and_several_runs_have_rates_and_no_test():
    last = list(MAPS)[-1]
    outcomes = [static(OURS[0], i, 1) for i in range(6)] + [static(OURS[1], i, i % 2, seed=s) for i in range(6) for s in (0, 1)]
    outcomes += [static(last, i, 0.25, "expected") for i in range(6)]
    rows = {row.arm: row for row in over_all(readings(outcomes, CONFIG.arms, MAPS, 0.95))}
    assert (rows[OURS[1]].rate, rows[OURS[1]].p) == (0.5, None)
    assert (rows[last].grounding, rows[last].rate) == (POSITIONS, 0.25)
