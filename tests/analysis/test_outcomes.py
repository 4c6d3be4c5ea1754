"""Static outcomes: the disc of the gate, what is known of an episode, and every arm answering every episode once."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis.outcomes import Outcome, static_outcomes
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, AbstentionReason, Answer, Prediction, UniformPick
from ovman.records.task import Relation
from tests.episodes import episode_record

CASE = Episode.from_json(episode_record("moved", answer=(1.0, 2.0)))
OTHER = Episode.from_json(episode_record("former", answer=(-1.0, 0.5)))
offset = st.floats(-3, 3).map(lambda value: round(value, 3))


def judge(outcome, case=CASE, radius=1.0, seed=0):
    predictions = [Prediction.of(case.id, "arm", 0, outcome)]
    (row,) = static_outcomes([case], predictions, radius_m=radius, samples=5000, seed=seed)
    return row


@given(offset, offset, st.floats(0.1, 3), st.floats(0.1, 3))
def test_the_static_gate_is_a_disc_about_the_answer(dx, dz, one, other):
    small, large = sorted((one, other))
    answer = Answer(CASE.answer[0] + dx, CASE.answer[1] + dz)
    rows = [judge(answer, radius=radius) for radius in (small, large)]
    assert rows[0].success <= rows[1].success
    assert all(row.success == float(row.distance_m <= radius) for row, radius in zip(rows, (small, large), strict=True))
    assert rows[0].outcome == "answered" and rows[0].reason is None


def test_a_stochastic_pick_contributes_its_probability():
    row = judge(UniformPick((CASE.answer, (9.0, 9.0), (8.0, 8.0))))
    assert (row.outcome, row.distance_m) == ("expected", None)
    assert row.success == pytest.approx(1 / 3)


def chairs(**places):
    return [{"id": name, "category": "Chair", "x": x, "z": z} for name, (x, z) in places.items()]


def test_an_outcome_has_what_is_known_of_the_episode_and_of_the_answer():
    record = episode_record("moved", answer=(1.0, 2.0), world=chairs(a=(1.0, 2.0), b=(1.0, 6.0), c=(9.0, 9.0)))
    (change,) = record["changes"]
    case = Episode.from_json(record | {"changes": [change, {**change, "instance": "b"}]})
    known, near = (case.id, "FloorPlan1", Relation.MOVED, "Chair", 2, 2, "arm", 0), {"neighbour_m": 4.0}
    sure = Outcome(*known, "answered", 1.0, distance_m=1.0, other_m=3.0, confidence=0.75, **near)
    assert judge(Answer(1.0, 3.0, 0.75), case) == sure
    assert judge(Answer(1.0, 5.0), case) == Outcome(*known, "answered", 0.0, distance_m=3.0, other_m=1.0, **near)
    assert judge(Abstention(AbstentionReason.UNSURE), case) == Outcome(*known, "abstained", 0.0, reason="unsure", **near)


def test_every_arm_answers_every_episode_once():
    here, there = (Prediction.of(case.id, "arm", 0, Answer(0.0, 0.0)) for case in (CASE, OTHER))
    arguments = {"radius_m": 1.0, "samples": 10, "seed": 0}
    with pytest.raises(ValueError, match="1 episodes are missing, the first is FloorPlan1/former/0000"):
        static_outcomes([CASE, OTHER], [here], **arguments)
    with pytest.raises(ValueError, match="FloorPlan1/moved/0000 is there twice"):
        static_outcomes([CASE], [here, here], **arguments)
    with pytest.raises(ValueError, match="arm answers FloorPlan1/former/0000, which is not among the episodes"):
        static_outcomes([CASE], [here, there], **arguments)
    with pytest.raises(ValueError, match="seed 1: 1 episodes are missing"):
        static_outcomes([CASE, OTHER], [here, there, here.model_copy(update={"seed": 1})], **arguments)


@pytest.mark.parametrize("relation", ["former", "moved"])
def test_the_other_instances_are_those_of_the_visit_that_the_answer_belongs_to(relation):
    sofa = {"id": "c", "category": "Sofa", "x": 7.0, "z": 0.0}
    record = episode_record(relation, world=[*chairs(a=(1.0, 0.0), b=(5.0, 0.0)), sofa])
    another = "world_1" if relation == "moved" else "world_2"
    case = Episode.from_json(record | {another: chairs(a=(1.0, 0.0))})
    assert (case.answer, judge(Answer(7.0, 0.0), case).other_m) == ((1.0, 0.0), 2.0)


@pytest.mark.parametrize(
    ("relation", "first", "second", "neighbour_m"),
    [
        # A past answer is beside what was there in the first visit and what is there in the second.
        ("former", {"b": (4.0, 4.0)}, {"b": (1.0, 9.0)}, 5.0),
        ("former", {"b": (1.0, 9.0)}, {"b": (4.0, 4.0)}, 5.0),
        ("former", {"b": (4.0, 4.0)}, {}, 5.0),
        # What was there before is not beside a current one.
        ("moved", {"b": (1.0, 0.5)}, {"b": (4.0, 4.0)}, 5.0),
        ("moved", {"b": (1.0, 0.5)}, {}, None),
    ],
)
def test_the_neighbour_is_the_nearest_of_the_visit_of_the_answer_and_of_the_second(relation, first, second, neighbour_m):
    worlds = {"world_1": chairs(a=(1.0, 0.0), **first), "world_2": chairs(a=(1.0, 0.0), **second)}
    case = Episode.from_json(episode_record(relation) | worlds)
    assert judge(Abstention(AbstentionReason.UNSURE), case).neighbour_m == neighbour_m
