"""`ovman eval`: runs are those of the release, a killed evaluation goes on, and a part of a split is no score."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys

import pytest

from ovman.analysis.rates import RATES
from ovman.analysis.rows import csv_text
from ovman.entry.manifest import Manifest, Where, manifest_of
from ovman.entry.release import Release
from ovman.entry.summary import as_json, as_text, summarise
from ovman.evaluation.tours import recording_key
from ovman.records.run import Score
from ovman.records.task import Relation
from ovman.settings import MAIN, Kind
from tests.arms import CONFIG
from tests.entry.evaluations import ASKED, SCENE, command, contents, lines, moving_everyday
from tests.entry.evaluations import DEPTH as ARM
from tests.episodes import DATA, EPISODES, ROOT, of_scene, released
from tests.runs import job

RELEASE = Release(DATA, CONFIG)
SEEDS = CONFIG.evaluation.seeds
FILES = {"attempts.jsonl", "finished", "runs.jsonl", "summary.json", "summary.md", "manifest.json"}


def evaluated(out, tours, *options):
    return command("eval", "--out", out, "--cache", tours, *options)


OPTIONS = ["--arm", ARM, "--split", MAIN, "--scenes", SCENE, "--seeds", "0", "1"]
"""Those of the fixture `depth_driving`."""


def test_the_runs_are_the_released_ones_and_a_part_of_a_split_is_no_score(depth_driving):
    ours = lines(depth_driving / "runs.jsonl")
    theirs = [line for line in lines(DATA / "scores" / MAIN / f"{ARM}.jsonl") if f'"episode":"{SCENE}/' in line]
    assert ours == [line for line in theirs if '"seed":2' not in line] and len(theirs) == 3 * ASKED
    assert {path.name for path in depth_driving.iterdir() if not path.name.startswith(".")} == FILES
    manifest = Manifest.read(depth_driving / "manifest.json")[0]
    summary = json.loads((depth_driving / "summary.json").read_text())
    assert (manifest.n, len(manifest.asked), manifest.is_whole) == (219, ASKED, False)
    assert not summary["whole"] and summary["released"] == [] and summary["tests"] == []
    assert f"PARTIAL, {ASKED} of 219 episodes, no score" in lines(depth_driving / "summary.md")[0]


def test_what_is_there_is_not_made_again(depth_driving, tours, tmp_path, capsys):
    out = shutil.copytree(depth_driving, tmp_path / "out")
    assert evaluated(out, tours, *OPTIONS) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == f"{2 * ASKED} of {2 * ASKED} runs are there already"
    assert not [line for line in said if "recording" in line or "left" in line]
    assert contents(out) == contents(depth_driving)


@pytest.mark.soak
def test_killed_it_goes_on_where_it_was(depth_driving, tours, tmp_path, capsys):
    """SIGKILL after a run."""
    out = tmp_path / "out"
    run = [sys.executable, "-m", "ovman.cli", "eval", "--out", str(out), "--cache", str(tours), *OPTIONS]
    with subprocess.Popen(run, cwd=ROOT, stdout=subprocess.PIPE, text=True, start_new_session=True) as process:
        while not process.stdout.readline().startswith("1/4 "):
            pass
        os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL and not (out / "runs.jsonl").exists()
    assert evaluated(out, tours, *OPTIONS) == 0
    assert int(re.match(r"(\d) of 4 runs are there already", capsys.readouterr().out)[1]) >= 1
    for name in ("runs.jsonl", "summary.json"):
        assert (out / name).read_bytes() == (depth_driving / name).read_bytes()


def test_a_second_tour_of_its_own_sensors_that_err_and_what_moves_are_as_released(tmp_path, tours):
    episode = moving_everyday()
    (tmp_path / "one.jsonl").write_text(episode.to_line())
    assert evaluated(tmp_path / "out", tours, "--arm", ARM, "--episodes", tmp_path / "one.jsonl", "--seeds", "0", "1") == 0
    theirs = [run for run in Score.read(DATA / "scores" / "everyday" / f"{ARM}.jsonl") if run.episode == episode.id]
    assert Score.read(tmp_path / "out" / "runs.jsonl") == [run for run in theirs if run.seed in (0, 1)] and len(theirs) == 3


BROKEN = """
class Agent:
    looks = False
    def __init__(self, context): pass
    familiarise = revisit = lambda self, visit: None
    def ask(self, query): self.relation = query.relation
    def act(self, observation):
        from ovman.agents.interface import Action
        return Action.ABSTAIN if self.relation == "moved" else 1 / 0
"""


def test_an_agent_that_raises_is_one_line_and_costs_no_finished_run(tmp_path, tours, monkeypatch, capsys):
    (tmp_path / "broken.py").write_text(BROKEN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    options = ["--agent", "broken:Agent", "--needs", "--split", MAIN, "--scenes", SCENE, "--seeds", "0", "--nonce", ""]
    assert evaluated(tmp_path / "out", tours, *options) == 1
    last = capsys.readouterr().err.splitlines()[-1]
    assert re.sub(f"{SCENE}/[a-z]+/[0-9]+", "EPISODE", last) == (
        "ovman eval: EPISODE, seed 0: act raised ZeroDivisionError in broken.py, line 9: division by zero; "
        f"mend the agent; {tmp_path / 'out' / 'agent.log'} has the traceback"
    )
    assert len([*(tmp_path / "out" / "finished").rglob("*.json")]) == 1 and not (tmp_path / "out" / "runs.jsonl").exists()


def test_a_whole_split_has_the_released_rates_and_stands_beside_the_release():
    """The released runs of the control, as if they had been made: Table embodied, and the tests against the reference agent."""
    runs = Score.read(DATA / "scores" / MAIN / f"{ARM}.jsonl")
    arm = job(ARM)[0]
    manifest = manifest_of(arm, EPISODES.read_bytes(), MAIN, 219, [episode.id for episode in released()], SEEDS, Where.EVALUATOR)
    summary = summarise(runs, released(), manifest, RELEASE)
    wanted = [line for line in lines(DATA / "metrics" / "main" / "embodied_rates.csv") if line.startswith(f"{ARM},")]
    plain = [line.rsplit(",", 4)[0] for line in csv_text(RATES, summary.rates).splitlines()[1:]]
    assert plain == [line.rsplit(",", 4)[0] for line in wanted] and len(wanted) == 7  # the release adds statistics by scene
    (reference,) = RELEASE.references(Kind.EMBODIED)
    tests = {(test.baseline, test.seed, test.relation): test for test in summary.baselines.tests}
    assert {(reference, seed, "all") for seed in SEEDS} <= {*tests}
    assert all(tests[ARM, seed, "all"].p == 1.0 for seed in SEEDS)
    assert tests[reference, 0, "all"].wins - tests[reference, 0, "all"].losses == (
        tests[reference, 0, "all"].successes - tests[reference, 0, "all"].baseline_successes
    )
    text = as_text(summary, markdown=True)
    assert CONFIG.arms[reference].system in text and "PARTIAL" not in text and json.loads(as_json(summary))["whole"]
    assert re.search(rf"^controls reach the score of {ARM}, 0\.\d+: .*{CONFIG.arms[ARM].system} \(", text, re.MULTILINE)


def test_a_recording_follows_from_its_tour_and_not_from_the_question():
    by_relation = {}
    for episode in released():
        by_relation.setdefault(episode.relation, []).append(episode)
    for relation, episodes in by_relation.items():
        one = episodes[0]
        key = {which: recording_key(one, which) for which in ("first", "second")}
        assert key["first"] != key["second"]
        asked_otherwise = one.model_copy(update={"sentence": "?", "category": "Other", "spawn": one.spawn, "drift_m": {}})
        assert {which: recording_key(asked_otherwise, which) for which in key} == key
        dim = one.model_copy(update={"scene": "FloorPlan0"})
        assert not {recording_key(dim, which) for which in key} & {*key.values()}
        renamed = one.model_copy(update={"id": f"{one.id}0"})
        changed = [which for which in key if recording_key(renamed, which) != key[which]]
        assert changed == (["second"] if relation is Relation.MOVING else [])
    untouched = {recording_key(one, "first") for one in of_scene(SCENE) if one.visits.first == "untouched"}
    assert len(untouched) == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--agent", "nowhere:Agent", "--split", MAIN], "there is no module nowhere"),
        (["--agent", "json:Agent", "--split", MAIN, "--in-process"], "json has no function Agent; name one that it has"),
        (["--agent", "Agent", "--split", MAIN], "--agent: 'Agent' names no function; write"),
        (["--agent", "json:load", "--split", MAIN, "--name", "Mine!"], "--name: 'Mine!' cannot name an arm"),
        (["--agent", "json:load", "--split", MAIN, "--name", ARM], f"--name: {ARM} is an arm of config.yaml"),
        (["--agent", "json:load", "--split", MAIN, "--needs", "dualmap"], "--needs: dualmap is not made outside the workflow"),
        (
            ["--agent", "json:load", "--split", MAIN, "--in-process", "--needs", "maps"],
            "--in-process: json needs more than tours",
        ),
        (["--agent", "json:load", "--split", MAIN, "--server", "ws://x:1"], "--server: its agent is where it is"),
        (["--split", MAIN, "--server", "ws://x:1"], "--server: say what its agent is called"),
        (["--arm", "nobody", "--split", MAIN], "--arm: nobody is no arm of config.yaml; write one of"),
        (["--arm", CONFIG.comparisons.agent, "--split", MAIN], "does not drive from episodes and tours alone; write one of"),
        (["--arm", ARM, "--split", "mian"], "--split: mian is no split"),
        (["--arm", ARM, "--episodes", "absent.jsonl"], "absent.jsonl: No such file or directory"),
        (["--arm", ARM, "--split", MAIN, "--scenes", "FloorPlan6"], "--scenes: FloorPlan6 has no episode; write some of"),
        (["--arm", ARM, "--split", MAIN, "--seeds", "-1"], "--seeds: -1 is negative; write 0 or more"),
        (["--agent", "mine.py:Agent", "--split", MAIN], "--agent: mine.py is a file; write mine:Agent"),
    ],
)
def test_a_wrong_command_is_one_line(tmp_path, tours, capsys, options, said):
    assert evaluated(tmp_path / "out", tours, *options) == 1
    err = capsys.readouterr().err
    assert re.search(said, err) and err.count("\n") == 1 and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("own", "helper"), [("def f(:", ""), ("from crooked_helpers.one import two\nclass Agent: pass\n", "\nx = = 1")]
)
def test_an_agent_that_is_no_python_is_one_line(tmp_path, tours, monkeypatch, capsys, own, helper):
    """Its own file, or one that it imports from its package."""
    package = tmp_path / ("crooked_helpers" if helper else "crooked")
    package.mkdir()
    for name, text in {"__init__": "", "agent": own, "one": helper}.items():
        (package / f"{name}.py").write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    assert evaluated(tmp_path / "out", tours, "--agent", f"{package.name}.agent:Agent", "--split", MAIN) == 1
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and ("one.py, line 2, is not Python" if helper else "agent.py, line 1, is not Python") in err


def test_seeds_are_added_to_those_that_are_there(depth_first_seed, depth_driving, tours, tmp_path, capsys):
    out, options = shutil.copytree(depth_first_seed, tmp_path / "out"), ["--arm", ARM, "--split", MAIN]
    assert evaluated(out, tours, *options, "--scenes", SCENE, "--seeds", "1") == 0
    for name in ("runs.jsonl", "summary.json", "manifest.json"):
        assert (out / name).read_bytes() == (depth_driving / name).read_bytes()
    capsys.readouterr()
    assert evaluated(out, tours, *options, "--scenes", "FloorPlan7", "--seeds", "0") == 1
    assert f"holds runs on {ASKED} episodes that are not asked for now" in capsys.readouterr().err
    assert (out / "runs.jsonl").read_bytes() == (depth_driving / "runs.jsonl").read_bytes()


def test_a_folder_of_something_else_is_left_alone(tmp_path, tours, depth_driving, capsys):
    (tmp_path / "letters.txt").write_text("dear")
    assert evaluated(tmp_path, tours, "--arm", ARM, "--split", MAIN) == 1
    assert "holds something else than an evaluation" in capsys.readouterr().err
    assert evaluated(depth_driving, tours, "--arm", ARM, "--split", "everyday") == 1
    assert "holds an evaluation whose split is main, not everyday; name another folder" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["..", "{folder}"])
def test_a_file_of_episodes_replaces_no_folder(tmp_path, capsys, name):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("mine")
    record = of_scene(SCENE)[0].to_json()
    record["visits"]["first"] = name.format(folder=mine)
    (tmp_path / "hostile.jsonl").write_text(json.dumps(record) + "\n")
    there = {*tmp_path.rglob("*")}
    options = ["--arm", ARM, "--episodes", str(tmp_path / "hostile.jsonl"), "--seeds", "0"]
    assert evaluated(tmp_path / "out", tmp_path / "cache", *options) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "hostile.jsonl:1: visits.first: " in line
    assert {*tmp_path.rglob("*")} == there
