"""What is made of a network's weights, kept in the user's cache so that it is made once and not in every job.

It hangs on nothing but what its owner is called by; a file that is torn or was changed is made again, and where nothing can be
written nothing is kept. A file is written beside its place and renamed, so two processes may make the same one.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from ovman.perception.libraries import cache

AT_MOST = 16
"""Networks whose files are kept, those that were used last."""
_DIGEST = hashlib.sha256().digest_size


class NetworkCache:
    """The files of one network.

    owner: digest of all that they hang on, None for a network of which nothing is kept.
    """

    def __init__(self, owner: str | None) -> None:
        self._directory = None if owner is None else cache() / "networks" / owner

    def content(self, name: str, make: Callable[[], bytes]) -> bytes:
        """The content of that name; it is made, and kept, if it is not there whole."""
        if self._directory is None:
            return make()
        path = self._directory / name
        try:
            whole = path.read_bytes()
            os.utime(path.parent)
        except OSError:
            whole = b""
        if len(whole) >= _DIGEST and hashlib.sha256(whole[_DIGEST:]).digest() == whole[:_DIGEST]:
            return whole[_DIGEST:]
        made = make()
        with suppress(OSError):  # a full or read-only disk, or another process that forgets this network
            _write(path, hashlib.sha256(made).digest() + made)
            _forget(path.parent)
        return made


def _write(path: Path, whole: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        partial.write_bytes(whole)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def _forget(used: Path) -> None:
    """Removes the networks that were used longest ago."""
    others = [directory for directory in used.parent.iterdir() if directory != used]
    for directory in sorted(others, key=lambda one: one.stat().st_mtime, reverse=True)[AT_MOST - 1 :]:
        shutil.rmtree(directory, ignore_errors=True)
