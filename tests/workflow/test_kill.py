"""Killed at any moment, the same command goes on without a question and ends in the same bytes."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest

from ovman.atomic import remove
from tests.workflow.conftest import ROOT, World

ENDED_S = 20.0
STARTED_S = 120.0


def processes_in(directory: Path) -> dict[int, str]:
    """Return every process that works in a directory, with its name."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (process / "cwd").readlink() == directory:
                found[int(process.name)] = (process / "comm").read_text().strip()
        except OSError:
            continue
    return found


def start(world: World, *target: str) -> subprocess.Popen[bytes]:
    command = world.command(target=target) if target else world.command()
    return subprocess.Popen(command, cwd=ROOT, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def kill(world: World, run: subprocess.Popen[bytes]) -> None:
    """Kill Snakemake alone, and wait until all that it has started ended by itself."""
    run.send_signal(signal.SIGKILL)
    run.wait()
    deadline = time.monotonic() + ENDED_S
    while left := processes_in(world.directory):
        assert time.monotonic() < deadline, f"still at work: {left}"
        time.sleep(0.1)


def cached(world: World, rule: str) -> set[Path]:
    return {path for path in (world.directory / "results" / "cache" / rule).rglob("*.*") if path.suffix in (".json", ".npz")}


@pytest.mark.parametrize(
    ("rule", "target"),
    [
        pytest.param("trials", "results/trials/main.jsonl", marks=pytest.mark.soak),
        ("rollouts", "results/rollouts/main/two_visits_embodied.jsonl"),
        pytest.param("detections", "results/maps/main", id="behind a checkpoint"),
    ],
)
def test_killed_amid_a_stage_it_goes_on_from_the_finished_items(world: World, tmp_path: Path, rule: str, target: str) -> None:
    again = world.copy(tmp_path / "again")
    place = target.removeprefix("results/")
    for name in (f"cache/{rule}", rule, "scores", place):
        remove(again.directory / "results" / name)
    run, deadline = start(again, target), time.monotonic() + STARTED_S
    while not cached(again, rule):
        assert time.monotonic() < deadline and run.poll() is None, "no item was finished"
        time.sleep(0.01)
    kill(again, run)
    finished = {path: path.stat().st_mtime_ns for path in cached(again, rule)}
    said = again.snakemake(target=target)
    assert said.returncode == 0, said.stdout
    assert len(cached(again, rule)) > len(finished)
    assert {path: path.stat().st_mtime_ns for path in finished} == finished
    made, expected = ({name: content for name, content in w.results().items() if name.startswith(place)} for w in (again, world))
    assert expected and made == expected


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(6))
def test_killed_at_random_moments_it_ends_in_the_same_bytes(world: World, tmp_path: Path, seed: int) -> None:
    rng, again = random.Random(seed), World(tmp_path)
    for _ in range(3):
        run = start(again)
        try:
            run.wait(timeout=rng.uniform(1.0, 40.0))
        except subprocess.TimeoutExpired:
            if rng.random() < 0.3 and (jobs := sorted(processes_in(again.directory).keys() - {run.pid})):
                os.kill(rng.choice(jobs), signal.SIGKILL)
                run.wait()
            else:
                kill(again, run)
    said = again.snakemake()
    assert said.returncode == 0, said.stdout
    assert again.results() == world.results()
    assert again.planned() == {}


def test_a_second_snakemake_in_one_directory_is_refused_in_one_line(tmp_path: Path) -> None:
    world = World(tmp_path)
    run, lock = start(world), tmp_path / ".snakemake" / "ovman.lock"
    try:
        deadline = time.monotonic() + STARTED_S
        while not lock.exists():
            assert time.monotonic() < deadline and run.poll() is None
            time.sleep(0.05)
        said = world.snakemake()
        assert said.returncode != 0
        assert said.stdout.splitlines()[-1].endswith("another Snakemake works in this directory; wait for it, or stop it")
    finally:
        kill(world, run)
