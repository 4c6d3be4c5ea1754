"""Outputs are there whole or not at all, a journal and the GPU have one holder, and no job outlives its Snakemake."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from ovman.settings.config import load
from ovman.workflow.job import UNWRITABLE, WORKFLOW_PID, job
from ovman.workflow.parameter import canonical
from ovman.workflow.snakefile import WRITTEN, check_writable
from tests import jobs
from tests.jobs import Named

ROOT = Path(__file__).parents[1]
PARAMETER = canonical(load(ROOT / "config.yaml"), "scenes")
rule = partial(jobs.rule, PARAMETER)
BEGINNING = """
import os, sys, time
from pathlib import Path
sys.path.insert(0, {root!r})
from functools import partial
from tests import jobs
from tests.jobs import Named
from ovman.workflow.job import job
rule = partial(jobs.rule, {parameter!r})
"""


@pytest.fixture(autouse=True)
def directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(WORKFLOW_PID, raising=False)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return tmp_path


def start(code: str, **environment: str) -> subprocess.Popen:
    text = BEGINNING.format(root=str(ROOT), parameter=PARAMETER) + textwrap.dedent(code)
    return subprocess.Popen([sys.executable, "-c", text], env=os.environ | environment)


def until(condition: Callable[[], bool], seconds: float = 30.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.02)


def files(directory: Path) -> set[str]:
    return {str(p.relative_to(directory)) for p in directory.rglob("*") if p.is_file()}


def test_what_says_all_in_its_line_needs_no_traceback(directory):
    class Missing(ValueError):
        says_all = True

    outputs = Named(one="one.txt")
    with pytest.raises(SystemExit) as ended, job(rule(output=outputs)) as work:
        work.output("one").write_text("half")
        raise Missing("a thing is missing; install it")
    assert ended.value.code == "a thing is missing; install it" and files(directory) == set()
    with pytest.raises(ValueError, match="a mistake"), job(rule(output=outputs)):
        raise ValueError("a mistake")


@pytest.mark.parametrize("number", sorted(UNWRITABLE))
def test_a_place_that_cannot_be_written_is_one_line(directory, number):
    with pytest.raises(SystemExit) as ended, job(rule(output=Named(one="one.txt"))):
        raise OSError(number, os.strerror(number), "results/one.txt")
    assert ended.value.code == f"results/one.txt: {os.strerror(number)}; make it writable for this user"


def test_a_read_only_working_directory_is_one_line(directory, monkeypatch):
    for name in ("results", "logs"):
        (directory / name).mkdir()
    check_writable(directory, WRITTEN)
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "results")
    check_writable(directory, ())
    with pytest.raises(SystemExit) as ended:
        check_writable(directory, WRITTEN)
    remedy = "make it writable for this user, or work elsewhere with --directory"
    assert ended.value.code == f"{directory / 'results'}: is read-only; {remedy}"


def test_an_output_appears_when_all_is_done(directory):
    with job(rule(output=Named(one="a/one.txt", two="a/two"))) as work:
        work.output("one").write_text("1")
        work.output("two").mkdir()
        (work.output("two") / "x").write_text("2")
        assert not (directory / "a/one.txt").exists() and not (directory / "a/two").exists()
        assert work.scene == "FloorPlan1" and work.constants.tour.waypoints == 6
    assert files(directory) == {"a/one.txt", "a/two/x"}


def test_a_failure_leaves_what_was_there_and_nothing_else(directory):
    (directory / "one.txt").write_text("old")
    with pytest.raises(ZeroDivisionError), job(rule(output=Named(one="one.txt", two="two"))) as work:
        work.output("one").write_text("new")
        work.output("two").mkdir()
        (work.output("two") / "x").write_text("2")
        _ = 1 / 0
    assert files(directory) == {"one.txt"} and (directory / "one.txt").read_text() == "old"
    assert not (directory / "two").exists()


def test_an_output_that_was_not_written_is_an_error(directory):
    with (
        pytest.raises(RuntimeError, match=r"scenes wrote no two\.txt"),
        job(rule(output=Named(one="one.txt", two="two.txt"))) as work,
    ):
        work.output("one").write_text("1")
        work.output("two")
    assert files(directory) == set()


def test_a_directory_is_replaced_whole(directory):
    for content in ("first", "second"):
        with job(rule(output=Named(tables="tables"))) as work:
            work.output("tables").mkdir()
            (work.output("tables") / content).touch()
    assert files(directory) == {"tables/second"}


def test_gathered_outputs_go_to_their_places(directory):
    with job(rule(output=Named(a="x/a.csv", b="y/b.csv"))) as work, work.gathered() as gathered:
        (gathered / "a.csv").write_text("a")
        (gathered / "b.csv").write_text("b")
    assert files(directory) == {"x/a.csv", "y/b.csv"}


def test_what_a_killed_job_left_is_cleared_by_the_next(directory):
    killed = start(
        """
        with job(rule(output=Named(one="one.txt"))) as work:
            work.output("one").write_text("half")
            Path("ready").touch()
            time.sleep(60)
        """
    )
    until((directory / "ready").exists)
    killed.kill()
    killed.wait()
    assert len(files(directory)) == 2 and not (directory / "one.txt").exists()
    with job(rule(output=Named(one="one.txt"))) as work:
        work.output("one").write_text("whole")
    assert files(directory) == {"ready", "one.txt"} and (directory / "one.txt").read_text() == "whole"


def test_what_a_job_and_its_children_say_is_in_its_log(directory):
    said = start(
        """
        with job(rule(log="logs/a/b.log")) as work:
            print("progress", flush=True)
            os.system("echo child")
            raise ValueError("what is wrong")
        """
    )
    assert said.wait() == 1
    log = (directory / "logs/a/b.log").read_text()
    assert "progress" in log and "child" in log and log.endswith("ValueError: what is wrong\n")


TURN = """
with job(rule(resources={resources}, wildcards=Named(scene={scene!r}))) as work:
    {before}
    with open("turns", "a") as turns:
        turns.write({name!r} + " in\\n")
        turns.flush()
        time.sleep(0.3)
        turns.write({name!r} + " out\\n")
"""


def turns(directory: Path, before: str, resources: dict[str, int], scenes: tuple[str, ...]) -> list[str]:
    started = [start(TURN.format(name=str(i), before=before, resources=resources, scene=scene)) for i, scene in enumerate(scenes)]
    assert [process.wait() for process in started] == [0] * len(started)
    return (directory / "turns").read_text().split("\n")[:-1]


def in_turn(lines: list[str]) -> bool:
    pairs = zip(lines[::2], lines[1::2], strict=True)
    return all(first.split()[0] == second.split()[0] for first, second in pairs)


def test_a_journal_has_one_writer(directory):
    assert in_turn(turns(directory, "work.journal()", {}, ("FloorPlan1",) * 3))
    assert (directory / "results/journal/scenes/FloorPlan1.lock").exists()


def test_jobs_with_a_gpu_run_one_at_a_time(directory):
    assert in_turn(turns(directory, "pass", {"gpu": 1}, ("FloorPlan1", "FloorPlan2", "FloorPlan3")))


def test_a_holder_that_is_killed_lets_go(directory):
    holder = start(
        """
        with job(rule(resources={"gpu": 1})) as work:
            work.journal()
            Path("ready").touch()
            time.sleep(60)
        """
    )
    until((directory / "ready").exists)
    waiting = start("with job(rule(resources={'gpu': 1})) as work: work.journal(); Path('second').touch()")
    time.sleep(0.3)
    assert not (directory / "second").exists()
    holder.kill()
    holder.wait()
    assert waiting.wait(timeout=30) == 0 and (directory / "second").exists()


def test_no_job_outlives_its_snakemake(directory):
    snakemake = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    orphan = start(
        """
        with job(rule(output=Named(one="one.txt"))) as work:
            work.output("one").write_text("half")
            Path("ready").touch()
            time.sleep(60)
        """,
        **{WORKFLOW_PID: str(snakemake.pid)},
    )
    until((directory / "ready").exists)
    assert orphan.poll() is None
    snakemake.send_signal(signal.SIGKILL)
    snakemake.wait()
    assert orphan.wait(timeout=10) == 1
    assert not (directory / "one.txt").exists()
    late = start("with job(rule()): Path('late').touch()", **{WORKFLOW_PID: str(snakemake.pid)})
    assert late.wait(timeout=30) == 1 and not (directory / "late").exists()


def test_the_journal_of_a_scene_is_the_same_in_a_job_of_several(directory):
    alone = Named(of="multi/", arm="mine", scene="FloorPlan1")
    with job(rule(wildcards=alone)) as work:
        place = work.journal()
    batch = rule(wildcards=Named(of="multi/", arm="mine"))
    batch.rule = "scenes_1"
    with job(batch) as work:
        places = [work.journal(scene) for scene in ("FloorPlan1", "FloorPlan2")]
    assert place == places[0] == Path("results/journal/scenes/multi/mine/FloorPlan1.jsonl") != places[1]
