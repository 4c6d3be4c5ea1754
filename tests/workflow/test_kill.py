"""Killed at any moment, the workflow goes on where it was and gives the tables that it would have given."""

from __future__ import annotations

import contextlib
import os
import random
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

from ovman.atomic import remove
from ovman.settings import Kind, Need, arms_of, of_kind
from tests.workflow.conftest import ROOT, World
from tests.workflow.test_reruns import CONFIG

FINISHED_S = 900
ENDED_S = 20.0
KEPT_S = 120.0
"""For a stage to keep its first unit, on a busy machine."""
SCENE = CONFIG.splits["main"].scenes[0]
WITH_MAPS = next(arm.name for arm in of_kind(arms_of(CONFIG.arms), Kind.EMBODIED) if Need.MAPS in arm.needs)
RUNS = f"results/scores/{WITH_MAPS}/seed0/{SCENE}.jsonl"
TRIALS = f"results/trials/{SCENE}.jsonl"
WALKS = f"results/walks/{SCENE}.npz"
MADE = {
    "trials": ("trials", "visits"),
    "rollouts": (f"rollouts/{WITH_MAPS}", f"scores/{WITH_MAPS}"),
    "walks": ("walks", "walk_labels"),
}
"""What a stage makes below the results of a finished world, and makes again."""
LOST = {"walks": 3}
"""A walk takes two seconds: the other ones are there, as a kill before would have left them."""
LONGEST_S = 40.0
"""Moments are drawn from this long a time, about that of a run on two free cores."""


def at_work(directory: Path) -> dict[int, str]:
    """Every process that works in `directory` and its name."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (process / "cwd").readlink() == directory:
                found[int(process.name)] = (process / "comm").read_text().strip()
        except OSError:
            continue
    return found


def started(world: World, *target: str) -> subprocess.Popen:
    environment = {k: v for k, v in os.environ.items() if k != "OVMAN_WORKFLOW_PID"}
    world.begin_with_sources()
    command = world.command(target=target) if target else world.command()
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen(command, cwd=ROOT, env=environment, start_new_session=True, **quiet)


def kill(world: World, run: subprocess.Popen) -> None:
    """Kill Snakemake, and wait until all that it started has ended by itself."""
    run.send_signal(signal.SIGKILL)
    run.wait()
    deadline = time.monotonic() + ENDED_S
    while left := at_work(world.directory):
        assert time.monotonic() < deadline, f"still at work: {left}"
        time.sleep(0.1)


def kept(world: World, stage: str) -> int:
    """How many units of a stage are kept in its journals."""
    files = [path for path in (world.directory / "results" / "journal" / stage).rglob("*") if path.is_file()]
    return sum(path.read_bytes().count(b"\n") if path.suffix == ".jsonl" else path.suffix == ".npz" for path in files)


def lose(world: World, stage: str) -> None:
    """Remove what a stage has made, and all that it has kept, or as many units as `LOST` says."""
    results = world.directory / "results"
    for name in MADE[stage]:
        remove(results / name)
    if stage in LOST:
        for unit in sorted((results / "journal" / stage).rglob("*.npz"))[: LOST[stage]]:
            unit.unlink()
    else:
        remove(results / "journal" / stage)


def killed_amid(world: World, stage: str, *target: str, job: bool) -> int:
    """Run the workflow, and kill the job of a stage, or Snakemake, when it has kept one unit more. How many it has then."""
    before, run = kept(world, stage), started(world, *target)
    deadline = time.monotonic() + KEPT_S
    while kept(world, stage) == before:
        assert time.monotonic() < deadline and run.poll() is None, f"nothing kept of {stage}"
        time.sleep(0.01)
    if not job:
        kill(world, run)
        return kept(world, stage)
    (victim,) = (pid for pid, name in at_work(world.directory).items() if name == stage)
    os.kill(victim, signal.SIGKILL)
    assert run.wait(timeout=FINISHED_S) != 0
    return kept(world, stage)


@pytest.mark.parametrize(
    ("stage", "target", "job"),
    [
        pytest.param("trials", TRIALS, False, marks=pytest.mark.soak),
        ("rollouts", RUNS, True),
        pytest.param("walks", WALKS, False, marks=pytest.mark.soak),
    ],
)
def test_killed_in_a_stage_that_keeps_units_it_finishes_with_the_same_bytes(world, tmp_path, stage, target, job):
    again = World(shutil.copytree(world.directory, tmp_path / "again"))
    lose(again, stage)
    before = kept(again, stage)
    found = killed_amid(again, stage, target, job=job)
    said = again.snakemake(target=target)
    assert said.returncode == 0, said.stdout
    assert before < found < kept(again, stage)
    assert again.results() == world.results()
    # Nothing that was finished was done again, and nothing follows from what was made again.
    units, all_units = again.units(), world.units()
    assert units == {name: all_units[name] for name in units}
    assert not list(again.directory.rglob("*.partial"))
    assert again.planned() == {}


def interrupted(world: World, victim: str, moment_s: float) -> None:
    """Run the workflow and kill one of its processes after a while, if there is one then."""
    run = started(world)
    with contextlib.suppress(subprocess.TimeoutExpired):
        run.wait(timeout=moment_s)
        return
    if victim == "snakemake":
        return kill(world, run)
    jobs = sorted(at_work(world.directory).keys() - {run.pid})
    if jobs:
        with contextlib.suppress(ProcessLookupError):
            os.kill(random.Random(moment_s).choice(jobs), signal.SIGKILL)
    run.wait(timeout=FINISHED_S)


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(8))
def test_killed_at_random_moments_it_finishes_with_the_same_bytes(world, tmp_path, seed):
    rng, kills = random.Random(seed), 3
    again = World(tmp_path)
    for _ in range(kills):
        interrupted(again, rng.choice(["snakemake", "snakemake", "job"]), rng.uniform(0.5, LONGEST_S / kills))
    said = again.snakemake()
    assert said.returncode == 0, said.stdout
    assert again.results() == world.results()
    # Nothing that was finished was done again.
    assert again.units() == world.units()
    assert not list(tmp_path.rglob("*.partial"))
    assert again.planned() == {}


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
