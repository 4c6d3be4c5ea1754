"""`--workers`: however an evaluation was shared out, the same bytes are left."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from ovman.settings import MAIN
from tests.entry.evaluations import DEPTH, SCENE, SECOND_SCENE, command
from tests.episodes import ROOT


@pytest.fixture(scope="module")
def one_process(tours, tmp_path_factory):
    """The evaluation of the control on two scenes, in one process."""
    out = tmp_path_factory.mktemp("one") / "out"
    options = ["--arm", DEPTH, "--split", MAIN, "--scenes", SCENE, SECOND_SCENE, "--seeds", "0"]
    assert command("eval", "--out", out, "--cache", tours, *options) == 0
    return out


def evaluation(out, tours):
    command = [sys.executable, "-m", "ovman.cli", "eval", "--arm", DEPTH, "--split", MAIN, "--scenes", SCENE, SECOND_SCENE]
    return [*command, "--seeds", "0", "--out", str(out), "--cache", str(tours), "--workers", "2"]


def test_workers_leave_the_bytes_of_one_process_even_where_one_is_killed(one_process, tours, tmp_path):
    one, two = one_process, tmp_path / "two"
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
