"""A store of detections keyed by the content of a tour and of the networks, so that identical tours are processed once.

Files are written beside their place and renamed, so that processes may write the same file at once.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from ovman.perception.array_file import ArrayFileError
from ovman.perception.detected import Detected
from ovman.perception.records import read_detections, write_detections


class Store:
    """Detections in a directory, one file a tour."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory

    def kept(self, content: str, look: Callable[[], Detected]) -> tuple[Detected, bool]:
        """The detections of a content, and whether the store had them. `look` makes missing ones, also for a damaged file."""
        path = self._directory / content[:2] / f"{content}.npz"
        if path.exists():
            try:
                return read_detections(path)[content], True
            except (ArrayFileError, KeyError):
                path.unlink(missing_ok=True)
        for left in path.parent.glob(f".{path.name}.*.partial"):
            if not _alive(int(left.name.split(".")[-2])):
                left.unlink(missing_ok=True)
        partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
        try:
            write_detections(partial, {content: look()})
            os.replace(partial, path)
        finally:
            partial.unlink(missing_ok=True)
        return read_detections(path)[content], False


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
