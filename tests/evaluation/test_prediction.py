"""The record of a prediction."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.records.prediction import Abstention, AbstentionReason, Answer, Evidence, Prediction, UniformBox, UniformPick
from ovman.records.record import RecordError, lines
from ovman.settings import Kind, of_kind
from tests.arms import ARMS
from tests.episodes import DATA

finite = st.floats(-50, 50, allow_nan=False)
points = st.tuples(finite, finite)
outcomes = st.one_of(
    st.builds(Answer, finite, finite),
    st.builds(Abstention, st.sampled_from(AbstentionReason)),
    st.builds(UniformPick, st.lists(points, max_size=4).map(tuple)),
    st.builds(lambda a, b: UniformBox(min(a[0], b[0]), min(a[1], b[1]), max(a[0], b[0]), max(a[1], b[1])), points, points),
)


indices = st.lists(st.integers(0, 99), max_size=4).map(tuple)
evidence = st.none() | st.builds(
    Evidence, st.none() | indices, indices, st.lists(st.tuples(st.integers(0, 99), st.integers(0, 99)), max_size=4).map(tuple)
)


@given(outcomes, st.integers(0, 9), evidence)
def test_a_record_says_all_that_was_predicted(outcome, seed, evidence):
    prediction = Prediction.of("FloorPlan201/moved/0003", "positions_two_visits", seed, outcome, evidence)
    assert (prediction.outcome, prediction.evidence) == (outcome, evidence)
    record = json.loads(json.dumps(prediction.model_dump(mode="json", by_alias=True)))
    assert Prediction.from_json(record) == prediction
    assert record["schema"] == "ovman-prediction/1"


def test_released_predictions_are_read_and_written_to_the_same_bytes():
    static = {arm.name for arm in of_kind(ARMS, Kind.STATIC) if arm.on_main}
    files = sorted((DATA / "predictions").rglob("*.jsonl"))
    assert {file.stem for file in files if file.parent.name == "main"} == static
    for file in files[::3]:
        predictions = Prediction.read(file)
        assert lines(predictions).encode() == file.read_bytes(), file.name
        again = [Prediction.of(p.episode, p.arm, p.seed, p.outcome, p.evidence) for p in predictions]
        assert again == predictions, file.name


GOOD = {"schema": "ovman-prediction/1", "episode": "e", "arm": "a", "seed": 0, "x": 1.0, "z": 2.0}
BOX = {"x": None, "z": None, "box": {"x_min": 1.0, "z_min": 0.0, "x_max": 0.0, "z_max": 1.0}}


@pytest.mark.parametrize(
    "change, message",
    [
        ({"x": None, "z": None, "abstain": "tired"}, 'abstain: "tired" is not one of no_candidate, '),
        ({"evidence": {"grounded": {"first": [1]}}}, "evidence.grounded.second: the key is missing; add it"),
        (BOX, "its largest corner"),
    ],
)
def test_a_bad_line_is_named_with_its_remedy(tmp_path, change, message):
    record = {key: value for key, value in {**GOOD, **change}.items() if value is not None}
    path = tmp_path / "a.jsonl"
    path.write_text(json.dumps(GOOD) + "\n" + json.dumps(record) + "\n")
    with pytest.raises(RecordError, match=message) as caught:
        Prediction.read(path)
    assert str(caught.value).startswith(f"{path}:2: ") and "\n" not in str(caught.value)
