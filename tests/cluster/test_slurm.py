"""The workflow through a real SLURM with profiles/slurm: preempted, its Snakemake killed, it gives what the local run gives."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml

from ovman.workflow.resources import PROFILE
from tests.cluster import slurm as harness
from tests.cluster.slurm import Slurm
from tests.workflow.conftest import ROOT, SNAKEMAKE, TINY, World, world  # noqa: F401 (a fixture)
from tests.workflow.test_kill import kept

pytestmark = [pytest.mark.soak, pytest.mark.timeout(5400)]
STAGE_S = 900.0
FINISHED_S = 3600.0
QUICK = ("--slurm-no-account", "--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "2")
QUICK += ("--seconds-between-status-checks", "2", "--slurm-keep-successful-logs")
"""What a SLURM without accounting asks for, and how often a test looks."""


@pytest.fixture
def slurm(tmp_path: Path) -> Iterator[Slurm]:
    if lacking := harness.missing():
        pytest.skip(f"this machine has no {', '.join(lacking)}; {harness.REMEDY}")
    (tmp_path / "slurm").mkdir()
    with harness.running(tmp_path / "slurm") as started:
        yield started


class Run:
    """Snakemake with the profile, started in a working directory; it ends with this process."""

    def __init__(self, slurm: Slurm, directory: Path, *arguments: str) -> None:
        command = [*SNAKEMAKE, "--profile", "profiles/slurm", *QUICK, "--directory", str(directory), *arguments]
        self.log = directory.with_name(f"{directory.name}.log")
        with self.log.open("ab") as said:
            self.process = subprocess.Popen(
                command, cwd=ROOT, env=dict(slurm.environment), stdout=said, stderr=said, preexec_fn=harness.mortal
            )

    def wait(self, holds: Callable[[], bool], what: str, within_s: float = STAGE_S) -> None:
        """Wait until something holds while Snakemake runs."""
        end = time.monotonic() + within_s
        while not holds():
            assert time.monotonic() < end and self.process.poll() is None, f"{what}: {self.log.read_text()[-4000:]}"
            time.sleep(0.2)

    def finish(self) -> None:
        """Wait for its end, which is a good one."""
        try:
            assert self.process.wait(timeout=FINISHED_S) == 0, self.log.read_text()[-4000:]
        finally:
            self.process.kill()


def running(slurm: Slurm, group: str) -> list[str]:
    """The jobs that run of a group of the profile."""
    lines = slurm.ask("squeue", "--noheader", "--states=RUNNING", "--format=%i %k").splitlines()
    return [job for job, comment in map(str.split, lines) if comment.startswith(f"rule_{group}")]


def sum_of_minutes(*rules: str) -> str:
    """The time that a job of these rules asks for, in SLURM's form: they run one after the other."""
    asked = yaml.safe_load(PROFILE.read_text())["set-resources"]
    minutes = sum(int(asked[rule]["runtime"].removesuffix(" * attempt")) for rule in rules)
    return f"{minutes // 60:02}:{minutes % 60:02}:00"


def log_of(directory: Path, job: str) -> str:
    """What a job of SLURM said."""
    (path,) = (directory / ".snakemake" / "slurm_logs").rglob(f"{job}.log")
    return path.read_text()


def test_preempted_and_killed_it_finishes_with_the_bytes_of_the_local_run(slurm, world, tmp_path):  # noqa: F811
    again = World(tmp_path / "there")
    again.directory.mkdir()
    tiny = ("--configfile", str(TINY), "--", "results/tables")
    first = Run(slurm, again.directory, *tiny)

    # A job of a higher partition takes the node; the trials go on from their journal when it is given back.
    first.wait(lambda: kept(again, "trials") > 0, "no trial is kept")
    (job,) = running(slurm, "generation")
    asked = slurm.described(job)
    assert (asked["NumCPUs"], asked["TimeLimit"]) == (
        "1",
        sum_of_minutes("scenes", "candidates", "trials", "admissible", "certified"),
    )
    before = kept(again, "trials")
    slurm.ask("sbatch", "--partition=high", "--exclusive", "--mem=0", "--output=/dev/null", "--wrap=sleep 5")
    first.wait(lambda: slurm.queue()[job] == "PENDING", "not preempted")
    assert slurm.described(job)["Restarts"] == "1"
    slurm.ask("scontrol", "update", f"JobId={job}", "StartTime=now")  # SLURM waits for two minutes
    first.wait(lambda: slurm.queue()[job] == "COMPLETED", "not finished after the preemption")
    assert kept(again, "trials") > before

    # Snakemake is killed while a job runs and another one waits in the queue.
    first.wait(lambda: kept(again, "walks") > 0, "no walk is kept")
    (waiting,) = running(slurm, "walking")
    slurm.ask("scontrol", "requeue", waiting)
    first.wait(lambda: slurm.queue()[waiting] == "PENDING", "not queued again")
    first.process.send_signal(signal.SIGKILL)
    first.process.wait()
    left = {job for job, state in slurm.queue().items() if state in ("RUNNING", "PENDING")}
    assert waiting in left

    known = {*slurm.queue()}
    second = Run(slurm, again.directory, *tiny)
    second.wait(lambda: not {*slurm.queue()} <= known, "nothing is submitted")
    slurm.ask("scontrol", "update", f"JobId={waiting}", "StartTime=now")
    second.wait(lambda: all(slurm.queue()[one] not in ("RUNNING", "PENDING") for one in left), "a job of the killed run goes on")
    assert slurm.queue()[waiting] == "FAILED" and "a later run has taken over" in log_of(again.directory, waiting)
    second.finish()

    after, local = again.results(), world.results()
    assert after.keys() == local.keys() and [name for name in local if after[name] != local[name]] == []
    assert {name: sorted(keys) for name, keys in again.units().items()} == {
        name: sorted(keys) for name, keys in world.units().items()
    }, "a unit was made twice"
    assert not list(again.directory.rglob("*.partial"))
    assert again.planned() == {}


GPUS = """
import sys

sys.path.insert(0, {root!r})
from ovman.workflow.snakemake_internals import limit_gpu

limit_gpu(workflow)


rule all:
    input:
        expand("{{n}}.done", n=range(2)),


rule work:
    output:
        "{{n}}.done",
    resources:
        gpu=1,
        mem_mb=200,
        runtime=5,
    shell:
        "date +%s >> {{output}}; {python} -c 'from ovman.workflow.locks import gpu_lock; print(gpu_lock())' >> {{output}};"
        " sleep 15; date +%s >> {{output}}"
"""


@pytest.mark.parametrize(("given", "at_once"), [((), False), (("--set-resource-scopes", "gpu=local"), True)], ids=["one", "all"])
def test_gpu_jobs_run_one_at_a_time_or_as_many_as_slurm_has_gpus(slurm, tmp_path, given, at_once):
    """SLURM lends each another GPU, whose lock is another one."""
    (tmp_path / "Snakefile").write_text(GPUS.format(root=str(ROOT), python=sys.executable))
    command = [*SNAKEMAKE, "--executor", "slurm", "--jobs", "2", *QUICK, *given, "--", "all"]
    environment = dict(slurm.environment) | {"PYTHONPATH": str(ROOT)}
    said = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=STAGE_S)
    assert said.returncode == 0, said.stdout + said.stderr
    (began, lock, ended), (other_began, other_lock, other_ended) = (
        (tmp_path / f"{n}.done").read_text().split() for n in range(2)
    )
    overlap = min(int(ended), int(other_ended)) > max(int(began), int(other_began))
    assert overlap is at_once and (lock != other_lock) is at_once
