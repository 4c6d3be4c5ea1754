"""A cache of files derived from network weights (graphs, embeddings of phrases) in the user's cache folder.

The key is a digest of everything the content depends on. Every file begins with the digest of its content; a damaged file is
made again. Without write access nothing is cached. Files are written beside their place and renamed, so that processes may write
the same file at once.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from ovman.atomic import replace_bytes
from ovman.perception.libraries import cache

AT_MOST = 16
"""Most networks with cached files; the least recently used ones are removed."""
_DIGEST = hashlib.sha256().digest_size


class NetworkCache:
    """The cached files of one network.

    owner: digest of all that the files depend on; None caches nothing.
    """

    def __init__(self, owner: str | None) -> None:
        self._directory = None if owner is None else cache() / "networks" / owner

    def content(self, name: str, make: Callable[[], bytes]) -> bytes:
        """The content of a name; made and cached if the file is missing or damaged."""
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
        with suppress(OSError):  # a full or read-only disk, or another process that removes this network
            replace_bytes(path, hashlib.sha256(made).digest() + made)
            _forget(path.parent)
        return made


def _forget(used: Path) -> None:
    """Remove the least recently used networks."""
    others = [directory for directory in used.parent.iterdir() if directory != used]
    for directory in sorted(others, key=lambda one: one.stat().st_mtime, reverse=True)[AT_MOST - 1 :]:
        shutil.rmtree(directory, ignore_errors=True)
