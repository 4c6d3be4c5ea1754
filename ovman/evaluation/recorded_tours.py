"""Recorded tours as an agent is given them: frames and camera poses, and nothing else of the recording."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, cast

import numpy as np

from ovman.agents.interface import CameraPose, Observation, Visit
from ovman.perception import tour_files
from ovman.perception.backprojection import Camera
from ovman.records.visit import VisitFiles


class RecordedFrame(Observation):
    """A recorded frame. Each picture is read at its first use: an agent that uses only depth reads no colours."""

    _source: tuple[Path, int, VisitFiles]

    @staticmethod
    def of(file: Path, number: int, files: VisitFiles, camera: Camera) -> RecordedFrame:
        """Return the frame of that number of a recorded tour. files: Those of the tour."""
        pose = CameraPose(*camera.position, camera.yaw_deg, camera.horizon_deg)
        frame = RecordedFrame(None, None, pose, camera.field_of_view_deg)
        attributes = vars(frame)
        del attributes["rgb"], attributes["depth"]
        attributes["_source"] = file, number, files
        return frame

    @cached_property
    def rgb(self) -> np.ndarray:
        """(H, W, 3) uint8. TourError that names the file if it cannot be read; so has depth."""
        return tour_files.rgb(*self._source)

    @cached_property
    def depth(self) -> np.ndarray:
        """(H, W) float32, metres along the optical axis."""
        return tour_files.depth(*self._source)


class RecordedTour(Sequence[Observation]):
    """The frames of a recorded tour, each read from its files when it is looked at."""

    def __init__(self, file: Path, field_of_view_deg: float) -> None:
        self._file, self._field_of_view_deg = file, field_of_view_deg

    @cached_property
    def _cameras(self) -> list[Camera]:
        return tour_files.cameras(self._file, self._field_of_view_deg)

    @cached_property
    def _files(self) -> VisitFiles:
        return VisitFiles.load(self._file)

    @property
    def content(self) -> str:
        """Digest of frames and cameras. TourError if no tour is recorded."""
        return digest_tour(self._file, self._field_of_view_deg)

    def __len__(self) -> int:
        return len(self._cameras)

    def __getitem__(self, index: Any) -> Any:
        """Raises TourError that names the file of a recording that cannot be read."""
        if isinstance(index, slice):
            return tuple(self[i] for i in range(*index.indices(len(self))))
        number = range(len(self))[index]
        return RecordedFrame.of(self._file, number, self._files, self._cameras[number])


class RecordedVisit(Visit):
    """A recorded visit. Nothing of it is read before its first use: an agent that asks for nothing costs nothing."""

    __slots__ = ()

    def __init__(self, tour: RecordedTour, reachable: np.ndarray) -> None:
        object.__setattr__(self, "observations", tour)
        object.__setattr__(self, "reachable", reachable)

    @property
    def content(self) -> str:
        """See `Visit`. TourError if no tour is recorded."""
        return cast(RecordedTour, self.observations).content


def load_visit(file: Path, field_of_view_deg: float, reachable: np.ndarray) -> Visit:
    """Return the visit that was recorded in a file, with the positions (K, 2) that can be reached in it.

    Its first use raises TourError if no tour is recorded there.
    """
    return RecordedVisit(RecordedTour(file, field_of_view_deg), reachable)


@lru_cache(maxsize=256)
def digest_tour(file: Path, field_of_view_deg: float) -> str:
    """Return the digest of a recorded tour's frames and cameras, which is equal for tours that look the same."""
    return tour_files.digest(file, field_of_view_deg, "")
