"""A store of detections keyed by the content of a tour and of the networks, so that identical tours are processed once.

Files are written beside their place and renamed, so that processes may write the same file at once.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ovman.atomic import clear_partials, replacing
from ovman.perception.array_file import ArrayFileError
from ovman.perception.detected import Detected
from ovman.perception.records import read_detections, write_detections


class Store:
    """Detections in a directory, one file a tour."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory

    def kept(self, content: str, look: Callable[[], Detected]) -> tuple[Detected, bool]:
        """The detections of a content, and whether the store had them.

        look: makes those that are missing. A damaged file is named in one line, and its detections are made again.
        """
        path = self._directory / content[:2] / f"{content}.npz"
        if path.exists():
            try:
                return _whole(path, content), True
            except ArrayFileError as error:
                print(f"{error}; its tour is looked at again", flush=True)
                path.unlink(missing_ok=True)
        clear_partials(path)
        with replacing(path) as partial:
            write_detections(partial, {content: look()})
        return read_detections(path)[content], False


def _whole(path: Path, content: str) -> Detected:
    """The detections of a kept file, all arrays verified. ArrayFileError where it is damaged or of another tour."""
    found = read_detections(path)
    if content not in found:
        raise ArrayFileError(f"{path}: detections of another tour; remove the file and make it again")
    found[content].masks()  # read when they are asked for, and verified then
    return found[content]
