"""What is driven in the environment is what `ovman eval` drives, run by run and action by action."""

from __future__ import annotations

import sys
from importlib import import_module

import gymnasium
import pytest

import ovman.gym
from ovman.cli import main
from ovman.gym.playing import play
from ovman.models.episode import Episode
from ovman.models.relation import Relation
from ovman.models.run import Score
from tests.arms import CONFIG
from tests.episodes import DATA, ROOT, of_scene

CONTROL = next(name for name, entry in CONFIG.comparisons.controls.items() if entry.role == "depth_driving")
REFERENCE = next(name for name, arm in CONFIG.arms.items() if arm.executes == CONFIG.comparisons.agent)
SCENE = "FloorPlan10"


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


def file_of(path, episodes):
    path.write_text("".join(episode.to_line() for episode in episodes))
    return path


def evaluated(out, cache, episodes, *options):
    """The runs, by seed, in the order of the episodes."""
    told = ["eval", "--out", str(out), "--cache", str(cache), "--episodes", str(episodes), *options]
    assert main(told) == 0
    return Score.read(out / "runs.jsonl")


@pytest.fixture
def examples(monkeypatch):
    """The folder of the examples, as the working directory."""
    monkeypatch.chdir(ROOT / "examples")
    monkeypatch.setattr(sys, "path", [str(ROOT / "examples"), *sys.path])
    return import_module("gymnasium_agents")


@pytest.mark.parametrize("looks", [False, True])
def test_a_control_drives_as_it_does_outside(tmp_path, cache, looks):
    """Where the answer moves, under two seeds; and with sensors that err, whatever else is drawn for whoever looks."""
    moving = next(episode for episode in of_scene("FloorPlan7") if episode.relation is Relation.MOVING)
    everyday = next(one for one in Episode.load(DATA / "episodes" / "everyday.jsonl") if one.tours.second.sensors is not None)
    for episode, seeds in ((moving, (0, 1)), (everyday, (2,))):
        file = file_of(tmp_path / f"{episode.scene}.jsonl", [episode])
        wanted = evaluated(tmp_path / episode.scene, cache, file, "--arm", CONTROL, "--seeds", *map(str, seeds))
        with gymnasium.make(ovman.gym.ID, episodes=file, cache=cache, name=CONTROL, looks=looks) as env:
            assert [play(env, episode.id, seed) for seed in seeds] == wanted
        assert all(run.trace for run in wanted)


def test_the_example_finds_the_rates_of_ovman_eval(tmp_path, cache, examples, capsys):
    """The reference agent detects, maps and associates what the dictionary shows; the random one draws what it draws outside."""
    file = file_of(tmp_path / "two.jsonl", of_scene(SCENE))
    random = ["--agent", "gymnasium_agents:Wanderer", "--name", "random", "--in-process"]
    wanted = {"random": evaluated(tmp_path / "random", cache, file, *random, "--seeds", "0")}
    wanted[REFERENCE] = evaluated(tmp_path / "reference", cache, file, "--arm", REFERENCE, "--seeds", "0")
    tables = [out.split("\n\n")[1] for out in capsys.readouterr().out.split("episodes of a file")[1:]]
    assert len(tables) == 2 and "SPL" in tables[0]
    found = examples.main(["--arm", REFERENCE, "--episodes", str(file), "--seeds", "0", "--cache", str(cache)])
    said = capsys.readouterr().out
    assert [found[name] for name in ("random", REFERENCE)] == [wanted["random"], wanted[REFERENCE]]
    assert all(table in said for table in tables)
    assert wanted["random"][0].trace != wanted["random"][1].trace
