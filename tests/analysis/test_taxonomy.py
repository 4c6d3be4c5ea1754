from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis.navigation import navigation
from ovman.analysis.outcomes import Case, static_outcomes
from ovman.analysis.taxonomy import LOST, Verdict, taxonomy, verdict
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, AbstentionReason, Answer, Prediction
from ovman.settings import Kind
from ovman.settings.arms import ArmJob
from tests.analysis.fabricated import embodied, static
from tests.episodes import TARGET, episode_record

R, NEAR = 1.0, 2.0
coordinate = st.floats(-4, 4).map(lambda value: round(value, 2))
point = st.tuples(coordinate, coordinate)
EXECUTED = ArmJob(name="driven", kind=Kind.EMBODIED, agent="x:y", executes="two_visits")


def episode(
    relation: str, target: tuple[float, float], others: list[tuple[float, float]], elsewhere: list[tuple[float, float]] = ()
):
    """An episode whose answer is the target; elsewhere: instances of the visit that the answer does not belong to."""

    def world(points, start):
        return [
            {"id": TARGET if start + i == 0 else f"k{start + i}", "category": "Chair", "x": x, "z": z}
            for i, (x, z) in enumerate(points)
        ]

    here = world([target, *others], 0) + [{"id": "vase", "category": "Vase", "x": target[0] + 2.5, "z": target[1]}]
    past = relation in ("former", "removed")
    return Case.of(
        Episode.from_json(
            episode_record(relation, answer=target, world=here) | {f"world_{2 if past else 1}": world(elsewhere, 0)}
        )
    )


def judge(case, outcome):
    (row,) = static_outcomes([case], [Prediction.of(case.id, "two_visits", 0, outcome)], radius_m=R, samples=10, seed=0)
    return verdict(row, R, NEAR)


@given(st.sampled_from(["moved", "former", "removed"]), point, st.lists(point, max_size=4), point)
def test_the_verdict_is_what_the_distances_say(relation, target, others, predicted):
    def distance(where):
        return ((where[0] - predicted[0]) ** 2 + (where[1] - predicted[1]) ** 2) ** 0.5

    got = judge(episode(relation, target, others), Answer(*predicted))
    assert (got is Verdict.SUCCESS) == (distance(target) <= R)
    if got is not Verdict.SUCCESS:
        beside = any(distance(other) <= R for other in others)
        assert (got is Verdict.WRONG_INSTANCE) == beside
        assert beside or (got is Verdict.NEAR_MISS) == (distance(target) <= NEAR)
        assert beside or (got is Verdict.ELSEWHERE) == (distance(target) > NEAR)


def test_precedence():
    near, far = (1.5, 0.0), (9.0, 0.0)
    assert judge(episode("moved", (0.0, 0.0), []), Answer(*near)) is Verdict.NEAR_MISS
    assert judge(episode("moved", (0.0, 0.0), []), Answer(*far)) is Verdict.ELSEWHERE
    # Beside another instance it is that instance, however near the answer is; but a success stays one.
    assert judge(episode("moved", (0.0, 0.0), [near]), Answer(*near)) is Verdict.WRONG_INSTANCE
    assert judge(episode("moved", (0.0, 0.0), [far]), Answer(*far)) is Verdict.WRONG_INSTANCE
    assert judge(episode("moved", (0.0, 0.0), [(0.5, 0.0)]), Answer(0.4, 0.0)) is Verdict.SUCCESS
    assert judge(episode("moved", (0.0, 0.0), [near]), Abstention(AbstentionReason.NO_CANDIDATE)) is Verdict.ABSTAIN


def test_a_distance_that_is_a_threshold_counts_as_within_it():
    at = lambda other, own: verdict(static("two_visits", 0, False, distance_m=own, other_m=other), R, NEAR)  # noqa: E731
    assert at(R, 9.0) is Verdict.WRONG_INSTANCE and at(math.nextafter(R, 2.0), 9.0) is Verdict.ELSEWHERE
    assert at(None, NEAR) is Verdict.NEAR_MISS and at(None, math.nextafter(NEAR, 3.0)) is Verdict.ELSEWHERE


@pytest.mark.parametrize("relation", ["former", "removed", "moved", "moving", "stable", "appeared"])
def test_only_the_visit_of_the_answer_and_only_the_category_count(relation):
    record = episode(relation, (0.0, 0.0), [], elsewhere=[(7.0, 7.0), (9.0, 0.0)])
    assert judge(record, Answer(9.0, 0.0)) is Verdict.ELSEWHERE
    assert judge(record, Answer(2.5, 0.0)) is Verdict.ELSEWHERE


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.floats(0, 5), st.floats(0, 5) | st.none()), min_size=1, max_size=40))
def test_verdicts_partition_the_episodes_of_every_relation(episodes):
    outcomes = [
        static("two_visits", i, success, "answered" if answered else "abstained", distance_m=d if answered else None, other_m=o)
        if answered
        else static("two_visits", i, False, "abstained")
        for i, (success, answered, d, o) in enumerate(episodes)
    ]
    rows = taxonomy(outcomes, [], R, NEAR)
    by_relation: dict[str, list] = {}
    for row in rows:
        by_relation.setdefault(row.relation, []).append(row)
    for of_relation in by_relation.values():
        assert [row.verdict for row in of_relation] == [which.value for which in Verdict]
        assert {row.n for row in of_relation} == {sum(row.episodes for row in of_relation)}
    assert {row.n for row in by_relation["all"]} == {len(episodes)}
    for which in Verdict:
        counts = {row.relation: row.episodes for row in rows if row.verdict == which.value}
        assert counts["all"] == sum(count for relation, count in counts.items() if relation != "all")


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), min_size=1, max_size=30))
def test_what_navigation_loses_is_a_subset_of_the_successes(episodes):
    outcomes = [static("two_visits", i, answered) for i, (answered, *_) in enumerate(episodes)]
    runs = [embodied("driven", i, run[seed], seed) for seed in (0, 1) for i, (_, *run) in enumerate(episodes)]
    rows = taxonomy(outcomes, navigation(outcomes, runs, [EXECUTED]), R, NEAR)
    successes = {row.relation: row.episodes for row in rows if row.verdict == Verdict.SUCCESS}
    lost = {(row.seed, row.relation): row.episodes for row in rows if row.verdict == LOST}
    assert {seed for seed, _ in lost} == {0, 1}
    assert all(count <= successes[relation] for (_, relation), count in lost.items())
    for seed in (0, 1):
        assert lost[seed, "all"] == sum(answered and not run[seed] for answered, *run in episodes)


def test_a_stochastic_pick_has_no_verdict():
    pick = static("single_visit", 0, 0.4, "expected")
    with pytest.raises(ValueError, match="a probability, no verdict"):
        verdict(pick, R, NEAR)
    assert taxonomy([pick], [], R, NEAR) == []
