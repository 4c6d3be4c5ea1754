"""A process that ends without a word has left what it was doing; one that finishes or fails leaves nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ovman.processes import HOST
from ovman.workflow import at_work

ROOT = Path(__file__).parents[1]
PROGRAM = """
import os, sys
sys.path.insert(0, {root!r})
from ovman.workflow import at_work
with at_work.job_at_work("rollouts", "logs/a.log"):
    at_work.note("arms.mine: FloorPlan1/moved/0001, seed 0")
    {end}
"""


@pytest.fixture(autouse=True)
def directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def ended(end: str) -> None:
    subprocess.run([sys.executable, "-c", PROGRAM.format(root=str(ROOT), end=end)], stderr=subprocess.DEVNULL)


@pytest.mark.parametrize("end", ["os._exit(0)", "os.kill(os.getpid(), 9)"])
def test_a_process_that_ends_without_a_word_is_named_once(directory, end):
    ended(end)
    cause = "killed, out of memory, or ended by the agent"
    where = "arms.mine: FloorPlan1/moved/0001, seed 0"
    line = f"rule rollouts: the process ended during {where} ({cause}); logs/a.log has what it printed"
    assert at_work.dead(directory) == [line] and at_work.dead(directory) == []


@pytest.mark.parametrize("end", ["pass", "raise ValueError", "sys.exit(0)"])
def test_a_job_that_ends_by_itself_leaves_nothing(directory, end):
    ended(end)
    assert at_work.dead(directory) == [] and not list((directory / at_work.FOLDER).iterdir())


def test_a_living_process_is_not_dead_and_one_that_said_nothing_is(directory):
    with at_work.job_at_work("scenes", "logs/b.log"):
        assert at_work.dead(directory) == [] and (directory / at_work.FOLDER / f"{HOST}.{os.getpid()}").exists()
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    path = directory / at_work.FOLDER / f"{HOST}.{gone.pid}"
    path.write_text('{"rule": "scenes", "log": "logs/b.log", "doing": ""}')
    (said,) = at_work.dead(directory)
    assert said.startswith("rule scenes: the process ended (killed, ")
    path.write_text("{torn")
    assert at_work.dead(directory) == [] and not path.exists()


def test_outside_a_workflow_nothing_is_written(directory):
    at_work.note("anything")
    assert list(directory.iterdir()) == []
