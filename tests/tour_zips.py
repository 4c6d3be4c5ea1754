"""Recorded tours, opened for tests: their files, and tours with other files."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np

from ovman.records.visit import FILES, VisitFiles, write_tour


def contents(tour: Path) -> dict[str, bytes]:
    """Return all files of a tour, by name."""
    with zipfile.ZipFile(tour) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def rewrite(tour: Path, changed: Mapping[str, bytes | None], sealed: bool = True) -> None:
    """Write a tour again with some files changed, or left out where they are None; their digests too if it is `sealed`."""
    kept = {name: content for name, content in (contents(tour) | changed).items() if content is not None}
    if sealed:
        key = VisitFiles.load(tour).key
        write_tour(tour, {name: content for name, content in kept.items() if name != FILES}, key)
        return
    with zipfile.ZipFile(tour, "w") as archive:
        for name, content in kept.items():
            archive.writestr(name, content)


def png(image: np.ndarray) -> bytes:
    """Return the PNG file of an image; colours are in the order blue, green, red."""
    return cv2.imencode(".png", image)[1].tobytes()


def picture(tour: Path, name: str) -> np.ndarray:
    """Return a picture of a tour as OpenCV reads it."""
    return cv2.imdecode(np.frombuffer(contents(tour)[name], np.uint8), cv2.IMREAD_UNCHANGED)


def change_picture(tour: Path, name: str) -> None:
    """Record another picture."""
    changed = picture(tour, name)
    changed[0, 0] = changed[0, 0] + 1
    rewrite(tour, {name: png(changed)})
