"""A cache of finished work items, keyed by the content of everything that an item depends on.

A work item is the smallest piece of work that is worth keeping: a measured trial, a certified run, a rollout, the detections of a
tour. A job that was killed, or whose inputs or settings changed in part, computes only the items that the cache lacks.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from ovman.atomic import replacing


def digest(*parts: Any) -> str:
    """Return 24 hexadecimal digits of JSON-serialisable parts, whatever the order of keys in them."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:24]


class Cache:
    """Values by key in one directory, one file per item. Processes may share it; deleting it loses nothing but time."""

    def __init__(self, directory: Path, fallback: Path | None = None) -> None:
        """Open the cache in `directory`. fallback: Another cache, whose items are read but never written."""
        self.directory, self.fallback = Path(directory), fallback

    def path(self, key: str, suffix: str = ".json") -> Path:
        """Return the file of an item, which may not exist. key: hexadecimal digits, as `digest` gives them."""
        name = Path(key[:2], f"{key[2:]}{suffix}")
        if self.fallback is not None and (self.fallback / name).exists():
            return self.fallback / name
        return self.directory / name

    def get_or_compute(self, key: str, compute: Callable[[], Any]) -> Any:
        """Return the JSON value of an item; compute and store it first if the cache lacks it or its file is damaged."""
        path = self.path(key)
        with suppress(FileNotFoundError, ValueError):  # ValueError: the disk was full or the file was edited
            return json.loads(path.read_bytes())
        text = json.dumps(compute(), separators=(",", ":"))
        self.write(path, lambda place: place.write_bytes(text.encode()))
        return json.loads(text)

    def write(self, path: Path, write: Callable[[Path], object]) -> None:
        """Store an item in the file that `path` gives, by `write`, which gets the path of a file to write.

        A reader finds the item whole or not at all, also after a SIGKILL.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as partial:
            write(partial)
