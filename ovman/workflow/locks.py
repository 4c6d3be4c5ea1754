"""Locks between processes of one user; the kernel lets go of them however their holder ends.

A journal's lock lies beside the journal and holds between machines, where the file system that they share has locks. The GPU's
lock is one machine's: the GPUs of another are others.
"""

from __future__ import annotations

import errno
import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from ovman.processes import HOST

LENT = ("SLURM_JOB_GPUS", "SLURM_STEP_GPUS")
"""Where SLURM says which GPUs of the machine it has lent to a job."""
WITHOUT = frozenset({errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP})
"""Errors of a file system that has no locks."""


class NoLocksError(OSError):
    """A file system has no locks; one line: the file, and the remedy."""

    says_all = True


def gpu_lock() -> Path:
    """The file that stands for the GPU among all processes of this user on this machine.

    Where SLURM has lent GPUs to this job, for these alone: it lends none twice, and jobs with others need not wait. The folder is
    this machine's own; XDG_RUNTIME_DIR may be that of the machine which sent the job.
    """
    lent = next(filter(None, map(os.environ.get, LENT)), None)
    of = "".join(c if c.isalnum() else "-" for c in lent) if lent is not None else None
    name = f"ovman-gpu-{os.getuid()}-{HOST}" + (f"-{of}" if of is not None else "")
    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    folder = runtime if runtime and os.access(runtime, os.W_OK | os.X_OK) else tempfile.gettempdir()
    return Path(folder) / f"{name}.lock"


@contextmanager
def held(path: Path) -> Iterator[None]:
    """This process alone has the lock `path`; waits until it does, and says in the log that it waits. NoLocksError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        try:
            flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print(f"waiting for the process that has {path.name}", flush=True)
            flock(file, fcntl.LOCK_EX)
        yield


def flock(file: IO[str], operation: int) -> None:
    """The kernel's flock, which a file system of the network passes on. NoLocksError; BlockingIOError as flock's."""
    try:
        fcntl.flock(file, operation)
    except OSError as error:
        if error.errno in WITHOUT:
            remedy = "mount it with locks that hold between machines (Lustre: flock), or work elsewhere with --directory"
            raise NoLocksError(f"{file.name}: its file system has no locks; {remedy}") from None
        raise
