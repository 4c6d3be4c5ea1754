"""Every job is given its declared inputs alone and makes what it made in the finished world: no rule has a hidden input.

What lies in the directory beside them is kept from run to run and keyed by its content: journals, and the recorded tours of the
scenes whose manifests are inputs. The rule `trials` keeps the tours itself.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.workflow.conftest import World
from tests.workflow.test_reruns import CHECKPOINTS, FOLLOWS

JOB = re.compile(r"^(?:local)?(?:rule|checkpoint) (\w+):\n((?:    .*\n)+)", re.MULTILINE)
FILES = re.compile(r"^    (input|output): (.*)$", re.MULTILINE)
MANIFEST = re.compile(r"results/visits/\w+\.json")
TRIED = frozenset({"detections", "rollouts"})
"""Rules that read recorded tours, one job of each of which is tried in every run of the tests; the others in a soak."""


@dataclass(frozen=True)
class Declared:
    """What a dry run says of a job."""

    rule: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


def jobs(world: World) -> Iterator[Declared]:
    """The jobs that lead to the tables."""
    # A dry run plans nothing after a checkpoint that reruns.
    before = {"scenes", "candidates", "trials", "admissible", "certified", *CHECKPOINTS}
    after = sorted({name.partition(":")[0] for name in FOLLOWS} - before)
    said = [world.snakemake("--dry-run", *how) for how in (["--forceall"], ["--forcerun", *after])]
    assert [one.returncode for one in said] == [0, 0], said
    for rule, text in {found for one in said for found in JOB.findall(one.stdout)}:
        listed = {name: tuple(values.split(", ")) for name, values in FILES.findall(text)}
        yield Declared(rule, listed.get("input", ()), listed["output"])


def link(source: Path, place: Path) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    if source.is_dir():
        shutil.copytree(source, place, copy_function=os.link)
    else:
        os.link(source, place)


def check(world: World, job: Declared, directory: Path) -> None:
    """Run a job where its inputs are and nothing else."""
    sandbox = World(directory, world.checkout)
    tours = [Path(name).with_suffix("") for name in (*job.inputs, *job.outputs) if MANIFEST.fullmatch(name)]
    for name in (*job.inputs, *map(str, tours)):
        if not Path(name).is_absolute():
            link(world.directory / name, directory / name)
    shutil.copytree(world.directory / "results" / "journal", directory / "results" / "journal")
    said = sandbox.snakemake("--allowed-rules", job.rule, "--force", target=job.outputs[0])
    assert said.returncode == 0, f"{job}\n{said.stdout}"
    for name in job.outputs:
        made, was = directory / name, world.directory / name
        for path in [made] if made.is_file() else sorted(made.rglob("*.*")):
            if path.name != ".snakemake_timestamp":
                assert path.read_bytes() == (was / path.relative_to(made) if made.is_dir() else was).read_bytes(), path


@pytest.fixture(scope="module")
def declared(world):
    found = list(jobs(world))
    assert {"trials", "detections", "predictions", "rollouts", "tables"} < {job.rule for job in found}
    return found


def test_jobs_that_read_recorded_tours_need_what_they_declare(world, declared, tmp_path):
    tried = {job.rule: job for job in declared if any(name.startswith("results/visits/") for name in job.inputs)}
    for number, job in enumerate(tried[rule] for rule in sorted(TRIED)):
        check(world, job, tmp_path / str(number))


@pytest.mark.soak
def test_every_job_needs_what_it_declares(world, declared, tmp_path):
    for number, job in enumerate(declared):
        check(world, job, tmp_path / str(number))
