"""`ovman merge` and `--workers`: however an evaluation was shared out, the same bytes are left; what is not one is refused."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

from ovman.settings import MAIN
from tests.entry.evaluations import DEPTH, SCENE, SECOND_SCENE, command, contents, lines
from tests.episodes import ROOT


def test_shards_come_to_what_one_run_leaves(by_seed, depth_driving, tmp_path, capsys):
    assert command("merge", tmp_path / "out", *by_seed) == 0
    made, wanted = contents(tmp_path / "out"), contents(depth_driving)
    in_turn = {"attempts.jsonl"}
    assert made.keys() == wanted.keys()
    assert {name: made[name] for name in wanted.keys() - in_turn} == {name: wanted[name] for name in wanted.keys() - in_turn}
    for name in in_turn:
        assert sorted(made[name].splitlines()) == sorted(wanted[name].splitlines())
    assert command("merge", tmp_path / "again", tmp_path / "out", by_seed[0]) == 0
    assert contents(tmp_path / "again") == made


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("manifest.json", lambda text: text.replace(f'"arm":"{DEPTH}"', '"arm":"other"'), "arm: "),
        ("manifest.json", lambda text: text.replace('"code":"', '"code":"0'), "code: "),
        ("runs.jsonl", lambda text: text.split("\n", 1)[1], "nothing recorded"),
        ("runs.jsonl", lambda text: text.replace('"seed":1', '"seed":0'), "seed: recorded, not among [1]"),
    ],
)
def test_what_is_not_one_evaluation_is_one_line(by_seed, tmp_path, capsys, name, change, said):
    other = shutil.copytree(by_seed[1], tmp_path / "other")
    text = (other / name).read_text()
    assert change(text) != text
    (other / name).write_text(change(text))
    assert command("merge", tmp_path / "out", by_seed[0], other) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"ovman merge: {other}") and said in line
    assert not (tmp_path / "out").exists()


def test_runs_that_differ_are_refused(by_seed, tmp_path, capsys):
    other = shutil.copytree(by_seed[1], tmp_path / "other")
    runs = [json.loads(line) for line in lines(other / "runs.jsonl")]
    runs[0]["spl"] -= 0.25
    (other / "runs.jsonl").write_text("".join(json.dumps(run, separators=(",", ":")) + "\n" for run in runs))
    assert command("merge", tmp_path / "out", *by_seed, other) == 1
    assert f"{other}: {runs[0]['episode']}, seed 1: spl: {runs[0]['spl']}, another folder has" in capsys.readouterr().err


@pytest.fixture(scope="module")
def another_scene(tours, tmp_path_factory):
    """The evaluation of the control on another scene, under the first seed. No test writes into it."""
    out = tmp_path_factory.mktemp("another") / "out"
    options = ["--arm", DEPTH, "--split", MAIN, "--scenes", SECOND_SCENE, "--seeds", "0"]
    assert command("eval", "--out", out, "--cache", tours, *options) == 0
    return out


def test_a_gap_is_refused(by_seed, another_scene, tmp_path, capsys):
    """A scene under one seed and another under both are no evaluation of both scenes under both seeds."""
    assert command("merge", tmp_path / "out", *by_seed, another_scene) == 1
    assert "seed 1 in none with it; run it under seed 1, too" in capsys.readouterr().err


def evaluation(out, tours):
    command = [sys.executable, "-m", "ovman.cli", "eval", "--arm", DEPTH, "--split", MAIN, "--scenes", SCENE, SECOND_SCENE]
    return [*command, "--seeds", "0", "--out", str(out), "--cache", str(tours), "--workers", "2"]


def test_workers_leave_the_bytes_of_one_process_even_where_one_is_killed(by_seed, another_scene, tours, tmp_path):
    """Of one process a scene, merged."""
    one, two = tmp_path / "one", tmp_path / "two"
    assert command("merge", one, by_seed[0], another_scene) == 0
    with subprocess.Popen(evaluation(two, tours), cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        while process.poll() is None and not [*(two / "finished").rglob("*.json")]:
            time.sleep(0.05)
        children = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True, check=False).stdout.split()
        os.kill(int(children[-1]), signal.SIGKILL)
        _, said = process.communicate(timeout=60)
    if process.returncode:  # else the worker had nothing left to do
        assert said == "ovman eval: a worker process was killed; finished runs are kept, and the same command goes on\n"
    subprocess.run(evaluation(two, tours), cwd=ROOT, check=True, capture_output=True)
    assert (one / "runs.jsonl").read_bytes() == (two / "runs.jsonl").read_bytes()
    for name in ("summary.json", "manifest.json"):  # but for the run that the worker was in
        whole, killed = (json.loads((out / name).read_text()) for out in (one, two))
        assert {**whole, "repeated": []} == {**killed, "repeated": []}


@pytest.mark.soak
def test_a_worker_has_an_agent_process_of_its_own(tours, tmp_path, monkeypatch, capsys):
    """An ill agent in a worker ends the evaluation in one line, and costs its own runs where failures abstain."""
    (tmp_path / "ill.py").write_text(
        "class Agent:\n"
        "    def __init__(self, context): pass\n"
        "    familiarise = revisit = ask = lambda self, given: None\n"
        "    def act(self, observation): raise RuntimeError('lost')\n"
    )
    monkeypatch.chdir(tmp_path)
    options = ["--agent", "ill:Agent", "--needs", "--split", MAIN, "--scenes", SCENE, SECOND_SCENE, "--seeds", "0"]
    options += ["--cache", tours, "--workers", "2"]
    assert command("eval", "--out", tmp_path / "stops", *options) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "act raised RuntimeError" in said
    assert command("eval", "--out", tmp_path / "goes_on", *options, "--failures", "abstain") == 0
    failures = lines(tmp_path / "goes_on" / "failures.jsonl")
    assert len(failures) == len(lines(tmp_path / "goes_on" / "runs.jsonl")) > 2
