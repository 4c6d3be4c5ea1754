"""Locks between processes of one user; the kernel lets go of them however their holder ends."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def gpu_lock() -> Path:
    """The file that stands for the GPU among all processes of this user."""
    return Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()) / f"ovman-gpu-{os.getuid()}.lock"


@contextmanager
def held(path: Path) -> Iterator[None]:
    """This process alone has the lock `path`; waits until it does, and says in the log that it waits."""
    from filelock import FileLock, Timeout  # a job without a journal or a GPU starts without it

    path.parent.mkdir(parents=True, exist_ok=True)
    lock = FileLock(path)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        print(f"waiting for the process that has {path.name}", flush=True)
        lock.acquire()
    try:
        yield
    finally:
        lock.release()
