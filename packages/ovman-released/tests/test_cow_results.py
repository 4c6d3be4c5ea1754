"""What the released runner wrote, read: stop, path, actions; and a file that it would not have written."""

from __future__ import annotations

import json
import math

import pytest
from episodes import released
from hypothesis import given
from hypothesis import strategies as st

from ovman.evaluation.scores import score_rollout
from ovman.records.record import RecordError
from ovman_released.cow_controller import Verdict
from ovman_released.cow_results import Walk, imported

EPISODE = released("FloorPlan429/removed/0002")
NOWHERE = dict.fromkeys(("stop", "box_distance_m", "answer_distance_m", "navigable_distance_m", "visible_px"))
COORDINATE = st.floats(-9, 9, allow_nan=False).map(lambda x: round(x, 3))


def written(path, points, actions):
    trajectory = [{"x": x, "y": 0.9, "z": z, "rotation": 0.0, "horizon": 0.0} for x, z in points]
    taken = [{"action": action, "success": True} for action in actions]
    metrics = {"trajectory": trajectory, "actions_taken": taken, "success": True, "vision_error_in_case_of_fail": False}
    path.write_text(json.dumps({"episode_metrics": metrics, "episode_result": {"path": trajectory, "success": True}}))
    return path


@given(st.lists(st.tuples(COORDINATE, COORDINATE), min_size=1, max_size=12), st.booleans())
def test_the_path_is_what_lies_between_the_poses_and_a_stop_is_no_action(tmp_path_factory, points, stops):
    path = tmp_path_factory.mktemp("walk") / "walk.json"
    walked = ["MoveAhead"] * (len(points) - 1)
    walk = Walk.read(written(path, [*points, points[-1]] if stops else points, [*walked, "Stop"] if stops else walked))
    assert (walk.stopped, walk.actions) == (stops, len(points) - 1)
    assert walk.path_length_m == pytest.approx(sum(math.dist(a, b) for a, b in zip(points, points[1:], strict=False)))
    assert walk.path_length_m >= math.dist(points[0], points[-1]) - 1e-9


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "cannot be read"),
        ("[]", "expected an object"),
        ('{"episode_metrics": {"trajectory": []}}', "actions_taken"),
        ('{"episode_metrics": {"trajectory": [], "actions_taken": [{"action": 3}]}}', "expected text"),
        (
            '{"episode_metrics": {"trajectory": [{"x": 0, "z": 0}], "actions_taken": [{"action": "Stop"}]}}',
            "1 poses for 1 actions",
        ),
        ('{"episode_metrics": {"trajectory": [{"x": null, "z": 0}], "actions_taken": []}}', "expected a number"),
    ],
)
def test_what_the_runner_would_not_write_is_one_line_with_the_file(tmp_path, text, says):
    path = tmp_path / "walk.json"
    path.write_text(text)
    with pytest.raises(RecordError) as error:
        Walk.read(path)
    assert says in str(error.value) and str(path) in str(error.value) and "\n" not in str(error.value)


def test_a_spent_budget_is_a_failure_on_either_task():
    verdict = Verdict.from_json({"name": "a", "stopped": False, **NOWHERE})
    judged = score_rollout(imported(EPISODE, 0, Walk(((0.0, 0.0), (0.0, 0.25)), False), verdict), EPISODE, any_instance=True)
    assert (judged.outcome, judged.success, judged.own_success, judged.path_length_m) == ("budget", False, False, 0.25)


@pytest.mark.parametrize("verdict", [{"stopped": False}, {"stopped": True, "stop": {"x": 0.5, "z": 0.0, "yaw_deg": 0.0}}])
def test_a_verdict_on_another_run_is_refused(verdict):
    with pytest.raises(ValueError, match="run it again"):
        imported(EPISODE, 0, Walk(((0.0, 0.0), (0.0, 0.0)), True), Verdict.from_json({"name": "a", **NOWHERE, **verdict}))
