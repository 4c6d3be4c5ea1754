"""Reading of recorded training pictures."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ovman.training.pictures import Picture, ShownObject


@dataclass(frozen=True, slots=True)
class RecordedPicture:
    """One picture on disk: its folder and its number in the scene."""

    folder: Path
    number: int

    @property
    def image(self) -> Path:
        """The file of its RGB image."""
        return self.folder / "images" / f"{self.number:04d}.png"


def recorded(folders: Sequence[Path], every: int = 1) -> list[RecordedPicture]:
    """One of `every` pictures of each folder of `ovman.training.recording`."""
    return [
        RecordedPicture(folder, number)
        for folder in folders
        for number in range(0, len(list((folder / "images").glob("*.png"))), every)
    ]


def read(pictures: Sequence[RecordedPicture]) -> Iterator[Picture]:
    """The pictures, in their order. OSError for a picture that cannot be read."""
    objects: dict[Path, list[str]] = {}
    for one in pictures:
        if one.folder not in objects:
            objects = {one.folder: (one.folder / "objects.jsonl").read_text(encoding="utf-8").splitlines()}
        lines = json.loads(objects[one.folder][one.number])
        shown = tuple(ShownObject(o["type"], o["asset"], tuple(o["materials"]), tuple(o["size_m"])) for o in lines)
        rgb, ids = _png(one.image, cv2.IMREAD_COLOR)[..., ::-1], _png(one.folder / "ids" / one.image.name, cv2.IMREAD_UNCHANGED)
        yield Picture(rgb, ids.astype(np.int16) - 1, shown)


def _png(path: Path, mode: int) -> np.ndarray:
    picture = cv2.imread(str(path), mode)
    if picture is None:
        raise OSError(f"{path}: no picture that can be read; remove its folder and record the pictures again")
    return picture
