"""Detections by the content of what was looked at, so that identical tours are seen once, whatever their names and in every run.

A file is written beside its place and renamed, so that what exists is whole; two processes may write the same one.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ovman.atomic import clear_partials, replacing
from ovman.perception.records import Detected, RecordError, read_detections, write_detections


class Store:
    """Detections in a directory, one file a tour."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory

    def kept(self, content: str, look: Callable[[], Detected]) -> tuple[Detected, bool]:
        """The detections of a content, looked for and kept first if they are not there yet; and whether they were there.

        A file that cannot be read is made again.
        """
        path = self._directory / content[:2] / f"{content}.npz"
        if path.exists():
            try:
                return read_detections(path)[content], True
            except (RecordError, KeyError):
                path.unlink(missing_ok=True)
        clear_partials(path)
        with replacing(path) as partial:
            write_detections(partial, {content: look()})
        return read_detections(path)[content], False
