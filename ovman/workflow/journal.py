"""A journal keeps every finished unit of a long job, so that a killed job redoes only the unit that it was in.

One JSON line a unit, keyed by a digest of all that the unit depends on. A line that was being written when the process died has
no newline and is dropped on the next opening; nothing before it is lost.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any


def digest(*parts: Any) -> str:
    """Hexadecimal digest of JSON-serialisable parts, independent of key order."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:24]


class Journal:
    """Finished units of one job, on disk at `path`; opened and repaired on construction."""

    def __init__(self, path: Path) -> None:
        self.path = Path(path)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._units: dict[str, Any] = {}
        if self.path.exists():
            self._load()

    def _load(self) -> None:
        data = self.path.read_bytes()
        whole = data.rfind(b"\n") + 1
        if whole < len(data):
            os.truncate(self.path, whole)
        for line in data[:whole].splitlines():
            try:
                unit = json.loads(line)
            except json.JSONDecodeError:
                continue
            self._units[unit["key"]] = unit["record"]

    def __contains__(self, key: str) -> bool:
        return key in self._units

    def __getitem__(self, key: str) -> Any:
        return self._units[key]

    def write(self, key: str, record: Any) -> Any:
        """Keep `record` (JSON-serialisable) under `key`; it survives a SIGKILL once this returns."""
        line = json.dumps({"key": key, "record": record}, separators=(",", ":")) + "\n"
        with self.path.open("a") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
        self._units[key] = json.loads(line)["record"]
        return self._units[key]

    def unit(self, key: str, measure: Callable[[], Any]) -> Any:
        """The record under `key`, measured and kept first if it is not there yet."""
        return self._units[key] if key in self._units else self.write(key, measure())
