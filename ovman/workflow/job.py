"""A job of the workflow: its constants, its log, and outputs that are complete or absent.

The scripts of the workflow run inside `job`. A killed job blocks no later one: outputs are written beside their place and renamed
at the end, a journal belongs to one process at a time, and a job ends as soon as its Snakemake has died. Inputs are compared with
their checksums before the job begins, and outputs get theirs at its end.
"""

from __future__ import annotations

import errno
import gc
import os
import select
import shutil
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from ovman import atomic
from ovman.workflow import checksums
from ovman.workflow.at_work import job_at_work
from ovman.workflow.locks import gpu_lock, held
from ovman.workflow.parameter import StageSettings

WORKFLOW_PID = "OVMAN_WORKFLOW_PID"
"""Environment variable with the id of Snakemake's process; the Snakefile sets it."""
AGENTS = "OVMAN_AGENTS"
"""Environment variable with the folders of the overlays, in which agents may lie. Python searches them last, so that a file there
replaces no other module."""
COLLECTED = 10_000
"""GC threshold: event metadata are many small objects; CPython's default of 700 costs about 2 % of run time."""

UNWRITABLE = frozenset({errno.EROFS, errno.EACCES, errno.EPERM})
"""Errors of the operating system that say all in one line: a place is read-only or belongs to another user."""


class Job:
    """What a script needs of Snakemake's `snakemake` object. Use `job` to get one."""

    def __init__(self, snakemake: Any, stack: ExitStack) -> None:
        self._snakemake = snakemake
        self._stack = stack
        self._partial: dict[Path, Path] = {}
        self._digests = checksums.verified(_flat(snakemake.input))
        self.constants = StageSettings.parse(snakemake.params.constants)

    def __getattr__(self, name: str) -> str:
        """A wildcard of the rule, e.g. `job.scene`."""
        try:
            return str(self._snakemake.wildcards[name])
        except (KeyError, AttributeError):
            raise AttributeError(f"the rule {self._snakemake.rule} has no wildcard {name!r}") from None

    def input(self, name: str) -> Path:
        """An input of one file."""
        return Path(self._snakemake.input[name])

    def inputs(self, name: str) -> list[Path]:
        """An input of any number of files, in the order of the rule."""
        value = self._snakemake.input.get(name, [])
        return [Path(value)] if isinstance(value, str) else [Path(v) for v in value]

    def output(self, name: str) -> Path:
        """Where to write an output of one file or directory; it goes to its place when the job is done."""
        return self._beside(Path(self._snakemake.output[name]))

    def outputs(self, name: str) -> list[Path]:
        """Where to write an output of any number of files, in the order of the rule."""
        value = self._snakemake.output[name]
        return [self._beside(Path(v)) for v in ([value] if isinstance(value, str) else value)]

    @contextmanager
    def gathered(self) -> Iterator[Path]:
        """A directory to write all outputs of the rule into under their own names; they go to their places afterwards."""
        with tempfile.TemporaryDirectory() as directory:
            yield Path(directory)
            for place in map(Path, self._snakemake.output):
                shutil.copyfile(Path(directory, place.name), self._beside(place))

    def journal(self, scene: str | None = None) -> Path:
        """The journal of this job, which belongs to this process until the job ends; waits for a process that still has it.

        scene: of whose units it is, for a job of several scenes. Its place is that of a job of this scene alone.
        """
        wildcards = dict(self._snakemake.wildcards.items()) | ({} if scene is None else {"scene": scene})
        path = Path("results", "journal", self.constants.stage, *map(str, wildcards.values())).with_suffix(".jsonl")
        self._stack.enter_context(held(path.with_suffix(".lock")))
        return path

    def _beside(self, place: Path) -> Path:
        if place not in self._partial:
            place.parent.mkdir(parents=True, exist_ok=True)
            atomic.clear_partials(place)
            self._partial[place] = atomic.partial_path(place)
        return self._partial[place]

    def _done(self) -> None:
        for place, partial in self._partial.items():
            if not partial.exists():
                raise RuntimeError(f"{self._snakemake.rule} wrote no {place}")
        for place, partial in self._partial.items():
            if partial.is_dir():  # the outputs of a rule are Snakemake's, which asked for this one to be made again
                atomic.remove(place)
            atomic.put(partial, place)
            checksums.record(place, self._snakemake.rule, self._digests)

    def _failed(self) -> None:
        for partial in self._partial.values():
            atomic.remove(partial)


def _flat(files: Iterable[str | list[str]]) -> list[str]:
    return [name for value in files for name in ([value] if isinstance(value, str) else value)]


@contextmanager
def job(snakemake: Any) -> Iterator[Job]:
    """The job that `snakemake` describes. The rule's log gets what the job and its child processes print.

    A job that asks for a GPU waits until no other job of this user has one, also where Snakemake allows several. An exception
    with a true attribute `says_all` names the fault and the remedy in its one line: the log gets that line and no traceback.
    """
    gc.set_threshold(COLLECTED)
    _end_with(os.environ.get(WORKFLOW_PID))
    sys.path.extend(filter(None, os.environ.get(AGENTS, "").split(os.pathsep)))
    if snakemake.log:
        _log_to(Path(str(snakemake.log)))
    with ExitStack() as stack:
        if os.environ.get(WORKFLOW_PID):
            stack.enter_context(job_at_work(snakemake.rule, str(snakemake.log)))
        if int(snakemake.resources.get("gpu", 0)) > 0:
            stack.enter_context(held(gpu_lock()))
        work: Job | None = None
        try:
            work = Job(snakemake, stack)
            yield work
            work._done()
        except BaseException as error:
            if work is not None:
                with suppress(OSError):
                    work._failed()
            if getattr(error, "says_all", False):
                raise SystemExit(str(error)) from None
            if isinstance(error, OSError) and error.errno in UNWRITABLE and error.filename is not None:
                raise SystemExit(f"{error.filename}: {error.strerror}; make it writable for this user") from None
            raise


def _log_to(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    log = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o644)
    for stream in (1, 2):
        os.dup2(log, stream)
    os.close(log)


def _end_with(pid: str | None) -> None:
    """End this process as soon as the process `pid` has ended: an abandoned job must not write any more."""
    if not pid or not hasattr(os, "pidfd_open"):
        return
    try:
        watched = os.pidfd_open(int(pid))
    except ProcessLookupError:
        os._exit(1)

    def wait() -> None:
        poll = select.poll()
        poll.register(watched, select.POLLIN)
        poll.poll()
        os._exit(1)

    threading.Thread(target=wait, name="end-with-snakemake", daemon=True).start()
