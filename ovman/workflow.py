"""What the Snakefile asks of Snakemake beyond its rules: no stale lock, one GPU job at a time, no job without its Snakemake.

Imports nothing heavy: the Snakefile imports it.
"""

from __future__ import annotations

import fcntl
import os
from pathlib import Path
from typing import Any, TextIO

from ovman import provenance
from ovman.job import WORKFLOW_PID

ALIVE = Path(".snakemake", "ovman.alive")
"""Every Snakemake that works in a directory shares a lock on this file; the kernel takes it away from those that die."""
SOURCES = Path(".snakemake", "ovman.sources.json")
"""What the first process found in the code's files; each job would read them again."""
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
_kept: list[TextIO] = []


def prepare(workflow: Any) -> None:
    """Make this Snakemake and its jobs safe to kill and to start again; once, before the rules."""
    os.environ.update(ONE_THREAD)
    # Jobs import the code that the digest in their parameter is of, installed or not.
    paths = [str(workflow.basedir), *filter(None, [os.environ.get("PYTHONPATH")])]
    os.environ["PYTHONPATH"] = os.pathsep.join(paths)
    os.environ[WORKFLOW_PID] = str(os.getpid())
    provenance.remember(Path.cwd() / SOURCES)
    limit_gpu(workflow)
    if workflow.is_main_process:
        release_stale_locks(Path.cwd())


def limit_gpu(workflow: Any) -> None:
    """At most one job of those that ask for `gpu` at a time. A user's --resources replaces a profile's limit, but not this."""
    from snakemake.resources import Resource

    workflow.global_resources["gpu"] = Resource("gpu", 1)


def release_stale_locks(directory: Path) -> None:
    """Remove Snakemake's locks on `directory` if those who took them are dead, and say from now on that this process is alive.

    A Snakemake that was killed leaves its locks, and the next one would refuse to start.
    """
    path = directory / ALIVE
    path.parent.mkdir(parents=True, exist_ok=True)
    file = path.open("a")
    _kept.append(file)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        pass
    else:
        for lock in (directory / ".snakemake" / "locks").glob("*.lock"):
            lock.unlink(missing_ok=True)
    fcntl.flock(file, fcntl.LOCK_SH)
