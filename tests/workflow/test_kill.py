"""Killed at any moment, the workflow goes on where it was and gives the tables that it would have given."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.workflow.conftest import ROOT, World

FINISHED_S = 900
LONGEST_S = 40.0
"""Moments are drawn from this long a time, about that of a run on two free cores."""


def at_work(directory: Path) -> dict[int, str]:
    """Every process that works in `directory` and its command line."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (process / "cwd").readlink() == directory:
                found[int(process.name)] = (process / "cmdline").read_text().replace("\0", " ")
        except OSError:
            continue
    return found


def interrupted(world: World, victim: str, moment_s: float) -> bool:
    """Run the workflow and kill one of its processes after a while. Whether there was somebody to kill."""
    environment = {k: v for k, v in os.environ.items() if k != "OVMAN_WORKFLOW_PID"}
    run = subprocess.Popen(
        world.command(), cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    try:
        run.wait(timeout=moment_s)
        return False
    except subprocess.TimeoutExpired:
        pass
    if victim == "snakemake":
        run.send_signal(signal.SIGKILL)
        run.wait()
        deadline = time.monotonic() + 20
        while left := at_work(world.directory):
            assert time.monotonic() < deadline, f"still at work: {left}"
            time.sleep(0.1)
        return True
    jobs = sorted(at_work(world.directory).keys() - {run.pid})
    if jobs:
        with contextlib.suppress(ProcessLookupError):
            os.kill(random.Random(moment_s).choice(jobs), signal.SIGKILL)
    run.wait(timeout=FINISHED_S)
    return bool(jobs)


def check(world: World, directory: Path, seed: int, kills: int) -> None:
    rng = random.Random(seed)
    again = World(directory)
    for _ in range(kills):
        interrupted(again, rng.choice(["snakemake", "snakemake", "job"]), rng.uniform(0.5, LONGEST_S / kills))
    said = again.snakemake()
    assert said.returncode == 0, said.stdout
    assert again.results() == world.results()
    # Nothing that was finished was done again.
    assert again.units() == world.units()
    assert not list(directory.rglob("*.partial"))
    assert again.planned() == {}


def test_killed_at_two_random_moments_it_finishes_with_the_same_bytes(world, tmp_path):
    check(world, tmp_path, seed=0, kills=2)


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(1, 8))
def test_killed_at_many_random_moments_it_finishes_with_the_same_bytes(world, tmp_path, seed):
    check(world, tmp_path, seed, kills=3)


def test_a_lock_is_kept_while_its_snakemake_lives_and_goes_with_it(tmp_path):
    world = World(tmp_path)
    locks = tmp_path / ".snakemake" / "locks"
    run = subprocess.Popen(world.command(), cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 60
        while not list(locks.glob("*.lock")):
            assert time.monotonic() < deadline and run.poll() is None
            time.sleep(0.05)
        refused = world.snakemake()
        assert refused.returncode != 0 and "lock" in refused.stdout.lower()
        assert list(locks.glob("*.lock")) and run.poll() is None
    finally:
        run.send_signal(signal.SIGKILL)
        run.wait()
    assert list(locks.glob("*.lock"))
    assert world.snakemake("--dry-run").returncode == 0
    assert not list(locks.glob("*.lock"))
