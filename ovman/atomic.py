"""Atomic writes: a file or folder is complete or absent, also after a kill.

Content is written next to its place under a name with this machine and this process id, and renamed when it is complete:
two machines that share the folder may have processes of the same id. Imports nothing heavy.
"""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ovman.processes import HOST, alive

SUFFIX = ".partial"


def partial_path(place: Path) -> Path:
    """Return where this process writes the content of `place`: a hidden path next to it."""
    return place.with_name(f".{place.name}.{HOST}.{os.getpid()}{SUFFIX}")


def clear_partials(place: Path) -> None:
    """Remove what killed processes of this machine left of `place`; what living ones are writing stays."""
    for left in place.parent.glob(f".{place.name}.*{SUFFIX}"):
        *_, host, process = left.name.removesuffix(SUFFIX).split(".")
        if host == HOST and not (process.isdigit() and alive(int(process))):
            remove(left)


def put(partial: Path, place: Path, mark: str | None = None) -> None:
    """Move a whole file or folder to its place.

    A folder replaces an empty folder, or a folder that holds the file `mark`, by which it is known as OVMAN's. ValueError, in
    one line, for any other folder: it stays.
    """
    if partial.is_dir():
        check_own(place, mark)
        remove(place)
    os.replace(partial, place)


def check_own(place: Path, mark: str | None) -> None:
    """Raise ValueError, in one line, for a folder that holds files but not the file `mark`."""
    if place.is_dir() and any(place.iterdir()) and (mark is None or not (place / mark).is_file()):
        lacks = "is there already" if mark is None else f"holds other files and no {mark}"
        raise ValueError(f"{place}: {lacks}, so nothing is replaced; move it away, or name another folder")


@contextmanager
def replacing(place: Path, mark: str | None = None) -> Iterator[Path]:
    """Yield a path for a file or a folder, which replaces `place` at the end and is removed if the block raises.

    mark: as for `put`.
    """
    place.parent.mkdir(parents=True, exist_ok=True)
    partial = partial_path(place)
    remove(partial)
    try:
        yield partial
        put(partial, place, mark)
    finally:
        remove(partial)


def replace_bytes(place: Path, content: bytes) -> None:
    """Write a file of bytes whole."""
    with replacing(place) as partial:
        partial.write_bytes(content)


def durable_append(path: Path, content: bytes) -> None:
    """Append to a file; the content survives a SIGKILL and a power cut once this returns."""
    with path.open("ab") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def hold_lock(path: Path) -> Iterator[None]:
    """Hold the lock `path` among processes of this machine; wait while another process holds it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def remove(path: Path) -> None:
    """Remove a file, a link or a folder with all that is in it; nothing where nothing is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
