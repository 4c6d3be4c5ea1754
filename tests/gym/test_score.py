"""What is driven in the environment is what `ovman eval` drives, run by run and action by action."""

from __future__ import annotations

import sys
from importlib import import_module

import gymnasium
import pytest

import ovman.gym
from ovman.cli import main
from ovman.gym.playing import play
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.records.task import Relation
from tests.arms import CONFIG
from tests.episodes import DATA, ROOT, of_scene

CONTROL = next(name for name, entry in CONFIG.comparisons.controls.items() if entry.role == "depth_driving")
REFERENCE = next(name for name, arm in CONFIG.arms.items() if arm.executes == CONFIG.comparisons.agent)
SCENE = "FloorPlan10"


def file_of(path, episodes):
    path.write_text("".join(episode.to_line() for episode in episodes))
    return path


def evaluated(out, tours, episodes, *options):
    """The runs, by seed, in the order of the episodes."""
    told = ["eval", "--out", str(out), "--cache", str(tours), "--episodes", str(episodes), *options]
    assert main(told) == 0
    return Score.read(out / "runs.jsonl")


@pytest.fixture
def examples(monkeypatch):
    """The folder of the examples, as the working directory."""
    monkeypatch.chdir(ROOT / "examples")
    monkeypatch.setattr(sys, "path", [str(ROOT / "examples"), *sys.path])
    return import_module("gymnasium_agents")


def test_a_control_drives_as_it_does_outside(tmp_path, tours):
    """Where the answer moves and sensors err. It takes no pictures, and here they are drawn."""
    of_split = Episode.load(DATA / "episodes" / "everyday.jsonl")
    episode = next(one for one in of_split if one.relation is Relation.MOVING and one.tours.second.sensors is not None)
    file = file_of(tmp_path / "one.jsonl", [episode])
    (wanted,) = evaluated(tmp_path / "out", tours, file, "--arm", CONTROL, "--seeds", "1")
    with gymnasium.make(ovman.gym.ID, episodes=file, cache=tours, name=CONTROL, tours="reset") as env:
        assert play(env, episode.id, 1) == wanted
    assert wanted.actions > 0 and wanted.trace


@pytest.mark.soak
def test_the_example_finds_the_rates_of_ovman_eval(tmp_path, tours, examples, capsys):
    """The reference agent detects, maps and associates what the dictionary shows; the random one draws what it draws outside."""
    file, seeds = file_of(tmp_path / "one.jsonl", of_scene(SCENE)[:1]), ("--seeds", "0", "1")
    agents = {
        "random": ["--agent", "gymnasium_agents:Wanderer", "--name", "random", "--in-process"],
        REFERENCE: ["--arm", REFERENCE],
    }
    wanted = {name: evaluated(tmp_path / name, tours, file, *options, *seeds) for name, options in agents.items()}
    tables = [line for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]
    assert [line.split()[0] for line in tables] == ["relation", "moved", "all"] * 2
    assert examples.main(["--arm", REFERENCE, "--episodes", str(file), "--cache", str(tours), *seeds]) == wanted
    assert [line for line in capsys.readouterr().out.splitlines() if line.startswith("  ")] == tables
    assert wanted["random"][0].trace != wanted["random"][1].trace
