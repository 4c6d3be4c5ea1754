"""Whoever is killed, at whatever moment: the same command goes on, nothing is lost, and the same runs are left."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ovman.settings import MAIN
from tests.entry.evaluations import SCENE, WANDERER
from tests.episodes import ROOT

VICTIMS = {"evaluator": "ovman.cli", "agent": "ovman.entry.serve", "engine": "ovman_engine"}
KILLS = 30


def started(directory, out, tours):
    command = [sys.executable, "-m", "ovman.cli", "eval", "--agent", "wanderer:Wanderer", "--needs", "--split", MAIN]
    command += ["--scenes", SCENE, "--seeds", "0", "1", "--out", str(out), "--cache", str(tours)]
    path = os.pathsep.join(dict.fromkeys([str(ROOT), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]))
    environment = os.environ | {"PYTHONPATH": path}
    return subprocess.Popen(command, cwd=directory, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def processes(root):
    """Numbers and command lines of a process and all below it."""
    listed = subprocess.run(["ps", "-eo", "pid,ppid,args"], capture_output=True, text=True, check=True).stdout.splitlines()[1:]
    rows = [(int(pid), int(parent), command) for pid, parent, command in (line.split(None, 2) for line in listed)]
    found, waiting = {}, [root]
    while waiting:
        one = waiting.pop()
        found |= {pid: command for pid, _, command in rows if pid == one}
        waiting += [pid for pid, parent, _ in rows if parent == one]
    return found


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_kills_at_random_moments_leave_the_same_bytes(tmp_path, tours):
    (tmp_path / "wanderer.py").write_text(WANDERER)
    for name in ("cold", "whole"):  # the first records the tours
        begun = time.monotonic()
        with started(tmp_path, tmp_path / name, tours) as process:
            _, said = process.communicate()
        assert process.returncode == 0, said
    whole, taken = files(tmp_path / "whole"), time.monotonic() - begun
    draws, met = random.Random(7), dict.fromkeys(VICTIMS, 0)
    for number in range(KILLS):
        victim = list(VICTIMS)[number % len(VICTIMS)]
        out = tmp_path / f"out{number}"
        with started(tmp_path, out, tours) as process:
            while not (there := named(VICTIMS[victim], process.pid)) and process.poll() is None:
                time.sleep(0.05)
            time.sleep(draws.uniform(0.0, 0.8) * taken)
            for pid in named(VICTIMS[victim], process.pid)[-1:] if there else ():
                os.kill(pid, signal.SIGKILL)
                met[victim] += 1
            _, said = process.communicate(timeout=120)
        assert "Traceback" not in said and (process.returncode in (0, -signal.SIGKILL) or said.count("\n") == 1), said
        if process.returncode:
            with started(tmp_path, out, tours) as process:
                _, said = process.communicate(timeout=120)
            assert process.returncode == 0, said
        assert files(out) == whole, f"kill {number}, {victim}"
    assert min(met.values()) > KILLS // len(VICTIMS) // 2, met


def named(what, root):
    """Processes below `root`, it among them, whose command line has `what` in it."""
    return [pid for pid, command in processes(root).items() if what in command]


def files(out: Path):
    """The runs, and the rest without the number of attempts."""
    there = {name: json.loads((out / name).read_bytes()) for name in ("summary.json", "manifest.json")}
    for content in there.values():
        content.pop("repeated", None)
    return {"runs.jsonl": (out / "runs.jsonl").read_bytes(), **there}
