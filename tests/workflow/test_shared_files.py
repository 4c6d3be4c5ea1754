"""What holds where several machines share a working directory: locks, names of files, and jobs of a run that was killed."""

from __future__ import annotations

import errno
import fcntl
import os
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from ovman import atomic
from ovman.processes import HOST
from ovman.workflow import at_work, locks, runs
from ovman.workflow.snakefile import prepare
from tests.workflow.conftest import ROOT

FOLLOWS = "import sys, time; from pathlib import Path; from ovman.workflow import runs; runs.follow(Path(sys.argv[1]), 0.05); "


def test_the_lock_of_the_gpu_is_this_machines(monkeypatch, tmp_path):
    for name in locks.LENT:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert locks.gpu_lock() == tmp_path / f"ovman-gpu-{os.getuid()}-{HOST}.lock"
    monkeypatch.setattr(locks, "HOST", "another")
    assert locks.gpu_lock().name == f"ovman-gpu-{os.getuid()}-another.lock"


def test_the_runtime_folder_of_the_machine_that_sent_the_job_is_not_there(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "elsewhere"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with locks.held(locks.gpu_lock()):
        assert locks.gpu_lock().parent == tmp_path and not (tmp_path / "elsewhere").exists()


@pytest.mark.parametrize("variable", locks.LENT)
def test_jobs_with_other_gpus_of_a_machine_do_not_wait_for_each_other(monkeypatch, variable):
    for name in locks.LENT:
        monkeypatch.delenv(name, raising=False)
    found = []
    for lent in ("0", "1", "0,1", "0"):
        monkeypatch.setenv(variable, lent)
        found.append(locks.gpu_lock())
    assert found[0] == found[3] and len(set(found)) == 3 and all("/" not in path.name for path in found)


@pytest.mark.parametrize("number", sorted(locks.WITHOUT))
def test_a_file_system_without_locks_is_told_in_one_line(monkeypatch, tmp_path, number):
    def refuse(file: object, operation: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fcntl, "flock", refuse)
    with (
        pytest.raises(locks.NoLocksError, match=r"one\.lock: its file system has no locks; mount it") as said,
        locks.held(tmp_path / "one.lock"),
    ):
        pass
    assert said.value.says_all and "\n" not in str(said.value)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("ovman.workflow.snakefile.overlays", lambda workflow: [])
    workflow = SimpleNamespace(basedir=str(ROOT), is_main_process=True, dryrun=True, register_resource=lambda *_: None)
    with monkeypatch.context() as kept:
        kept.setattr(os, "environ", dict(os.environ))
        with pytest.raises(SystemExit, match="its file system has no locks"):
            prepare(workflow)


def test_another_error_of_a_lock_is_not_taken_for_that(monkeypatch, tmp_path):
    def refuse(file: object, operation: int) -> None:
        raise OSError(errno.EIO, "broken")

    monkeypatch.setattr(fcntl, "flock", refuse)
    with pytest.raises(OSError, match="broken"), locks.held(tmp_path / "one.lock"):
        pass


def test_what_another_machine_is_writing_stays_until_it_is_long_abandoned(tmp_path):
    place = tmp_path / "one.txt"
    theirs, folder = tmp_path / ".one.txt.node7.1.partial", tmp_path / ".one.txt.node7.2.partial"
    theirs.write_text("half")
    folder.mkdir()
    own = tmp_path / f".one.txt.{HOST}.{2**22 + 1}.partial"  # no process has that id
    own.write_text("half")
    atomic.clear_partials(place)
    assert theirs.exists() and folder.exists() and not own.exists()
    for path in (theirs, folder):
        os.utime(path, (0.0, time.time() - atomic.ABANDONED_S - 60))
    atomic.clear_partials(place)
    assert list(tmp_path.iterdir()) == []


def test_two_machines_write_the_same_place_under_names_of_their_own(monkeypatch, tmp_path):
    mine = atomic.partial_path(tmp_path / "one.txt")
    monkeypatch.setattr(atomic, "HOST", "another")
    assert atomic.partial_path(tmp_path / "one.txt") != mine and "." not in HOST and "/" not in HOST


def test_a_job_that_died_on_another_machine_is_named_when_all_have_ended(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    note = tmp_path / at_work.FOLDER / f"node7.{os.getpid()}"  # an id that lives here
    note.parent.mkdir(parents=True)
    note.write_text('{"rule": "rollouts", "log": "logs/a.log", "doing": "arms.mine"}')
    (line,) = at_work.dead(tmp_path)
    assert line.startswith("rule rollouts: the process ended during arms.mine") and not note.exists()


@pytest.fixture
def run(monkeypatch, tmp_path) -> Path:
    """A working directory with a run."""
    monkeypatch.setenv(runs.FOLLOWED, "1")
    monkeypatch.setenv(runs.RUN, "earlier")
    runs.begin(tmp_path)
    return tmp_path


def job(directory: Path, then: str = "time.sleep(60)", **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", FOLLOWS + then, str(directory)], env=os.environ | environment, stderr=subprocess.PIPE, text=True
    )


def test_a_job_that_begins_after_a_later_run_does_nothing(run):
    belated = job(run, "(Path(sys.argv[1]) / 'done').touch()", **{runs.RUN: "killed"})
    _, said = belated.communicate(timeout=60)
    assert belated.returncode == 1 and said == f"{run}: a later run has taken over; this job does nothing more\n"
    assert not (run / "done").exists()


def test_a_job_that_runs_ends_when_a_later_run_begins(run):
    working = job(run)
    time.sleep(1.0)
    assert working.poll() is None
    runs.begin(run)
    assert working.wait(timeout=60) == 1


@pytest.mark.parametrize("environment", [{runs.FOLLOWED: "1"}, {}], ids=["below another that follows", "of the run"])
def test_a_job_of_the_run_works_to_its_end(run, environment):
    working = job(run, "time.sleep(0.3); sys.exit(7)", **environment)
    if environment:
        runs.begin(run)
    assert working.wait(timeout=60) == 7


def test_a_run_is_no_part_of_the_one_that_started_it(run):
    assert runs.FOLLOWED not in os.environ and os.environ[runs.RUN] == (run / runs.FILE).read_text() != "earlier"


def test_a_file_system_that_does_not_answer_is_no_later_run(run):
    working = job(run, "time.sleep(0.3); sys.exit(7)")
    (run / runs.FILE).unlink()
    assert working.wait(timeout=60) == 7
