"""What the wrapper relies on, asked of a real clone of CoW: without weights, without a GPU, skipped where there is none.

COW_ROOT names the clone, COW_PYTHON the interpreter of its environment.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from episodes import released
from settings_of import PACKAGE, settings_of
from settings_of import ROOT as REPOSITORY_ROOT

from ovman.workflow.journal import Journal
from ovman.workflow.parameter import stage_settings
from ovman_released.cow import NEEDS, REPOSITORY, missing, passed
from ovman_released.cow_results import Walk
from ovman_released.interpreter import environment
from ovman_released.settings import released_cow

COW = released_cow(settings_of("cow"))
PROGRAM = Path(__file__).with_name("clone_cow.py")
STAND_IN = Path(__file__).parent / "stand_ins"
ALLOWED = {"MoveAhead", "RotateLeft", "RotateRight", "LookUp", "LookDown", "Stop"}
ROOT = os.environ.get("COW_ROOT", "")
real = pytest.mark.skipif(not ROOT, reason="COW_ROOT names no clone of CoW")


def ask(root: Path, python: str, *arguments: Any, path: Path | None = None) -> dict[str, Any]:
    env = environment(REPOSITORY_ROOT, PACKAGE)
    if path is not None:
        env["PYTHONPATH"] = f"{path}{os.pathsep}{env['PYTHONPATH']}"
    question, *places = map(str, arguments)
    command = [python, str(PROGRAM), question, str(root), *places]
    done = subprocess.run(command, capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.rpartition("OVMAN ")[2])


def of_clone(*arguments: Any) -> dict[str, Any]:
    return ask(Path(ROOT).absolute(), os.environ.get("COW_PYTHON", sys.executable), *arguments)


@real
def test_it_is_the_pinned_commit():
    from ovman_released.clone import Clone

    assert Clone(REPOSITORY, Path(ROOT).absolute(), COW.commit).lacks() is None and NEEDS.modules


@real
@pytest.mark.parametrize(
    ("word", "value"),
    [("VOXEL", 0.125), ("FORWARD", 0.25), ("ROT", 30), ("FOV", 90), ("HEIGHT", 0.8658), ("TOL", 0.05), ("CEIL", 1.9)],
)
def test_its_constants(word, value):
    numbers = of_clone("constants")["numbers"]
    named = [x for name, values in numbers.items() if word in name for x in values]
    assert any(abs(x - value) < 1e-4 for x in named), numbers


@real
def test_its_threshold():
    assert of_clone("constants")["thresholds"]["owl-b32-openai"] == COW.threshold


@real
def test_it_spins_explores_and_stops_at_what_it_was_shown():
    walk = of_clone("room")
    # It turns left until it is shown its target, after seven turns of 30 degrees, and then goes there without the other two.
    assert walk["actions"][:8] == ["RotateLeft"] * 7 + ["MoveAhead"] and set(walk["actions"]) <= ALLOWED
    assert walk["actions"][-1] == "Stop" and walk["told"] and walk["distance_m"] < 1.0 + 0.25 + 0.3


def served(tmp_path: Path, root: Path, python: str, path: Path | None = None) -> dict[str, Any]:
    start = {"x": 0.0, "y": 0.9, "z": 0.0}
    episode = {
        "scene": "FloorPlan1",
        "object_type": "Mug",
        "initial_position": start,
        "initial_orientation": 0.0,
        "initial_horizon": 0,
        "shortest_path": [start, start],
        "shortest_path_length": 0.0,
    }
    there, absent = "FloorPlan1_physics_moved_Mug_0000", "FloorPlan1_physics_removed_Mug_0001"
    job, results = tmp_path / "job.json", tmp_path / "results"
    results.mkdir()
    job.write_text(json.dumps([episode | {"id": absent, "object_id": "Mug|2"}, episode | {"id": there, "object_id": "Mug|1"}]))
    written = ask(root, python, "worker", job, results, path=path)
    assert set(written) == {there, absent}
    for name, record in written.items():
        metrics = record["episode_metrics"]
        assert {"trajectory", "actions_taken", "success", "vision_error_in_case_of_fail"} <= set(metrics)
        assert {"path", "shortest_path", "success"} <= set(record["episode_result"])
        assert [taken["action"] for taken in metrics["actions_taken"]] == ["RotateLeft", "Stop"]
        assert len(metrics["trajectory"]) == 3 and set(metrics["trajectory"][0]) == {"x", "y", "z", "rotation", "horizon"}
        walk = Walk.read(results / f"{name}.json")
        assert (walk.stopped, walk.actions, walk.path_length_m) == (True, 1, 0.0)
    assert not written[absent]["episode_metrics"]["success"]
    return written


@real
def test_its_runner_serves_a_target_that_is_there_and_one_that_is_not(tmp_path):
    served(tmp_path, Path(ROOT).absolute(), os.environ.get("COW_PYTHON", sys.executable))


@real
def test_episodes_come_to_their_end_as_the_workflow_runs_them(tmp_path, monkeypatch):
    """With a network of the same class that finds nothing, on the real engine: to the end of a budget of 14 actions."""
    assert "model.safetensors" in of_clone("weights", tmp_path / "cache")["files"]
    monkeypatch.setenv("HF_HOME", str(tmp_path / "cache"))
    python = os.environ.get("COW_PYTHON", sys.executable)
    given = {"root": str(Path(ROOT).absolute()), "python": python, "device": "cpu", "budget": 14}
    constants = stage_settings(settings_of("cow", released_cow=given), "released_cow")
    assert missing(constants) is None
    episodes = [released("FloorPlan429/moved/0000"), released("FloorPlan429/removed/0002")]
    rollouts = passed(episodes, 0, constants, Journal(tmp_path / "journal.jsonl"))
    assert [(one.episode, one.outcome, one.actions) for one in rollouts] == [(one.id, "budget", 14) for one in episodes]
    # Nine turns on the spot, then it explores.
    assert all(one.path_length_m > 0 for one in rollouts)


def test_the_stand_in_passes_the_same_test(tmp_path):
    """So that this test, too, is run where there is no clone."""
    served(tmp_path, STAND_IN / "cow", sys.executable, STAND_IN / "site")
