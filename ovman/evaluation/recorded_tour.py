"""Recorded tours as an agent is given them: frames and camera poses, and nothing else of the recording."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from pathlib import Path
from typing import overload

import numpy as np

from ovman.agents.interface import CameraPose, Observation, Visit
from ovman.perception.backprojection import Camera
from ovman.perception.tour_files import cameras, depth, digest, rgb
from ovman.records.visit_files import VisitFiles


class RecordedFrame(Observation):
    """A frame that was recorded. Each picture is read at its first use: who looks at depth alone pays for no colours."""

    _of: tuple[Path, int, VisitFiles]

    @staticmethod
    def of(directory: Path, number: int, files: VisitFiles, camera: Camera) -> RecordedFrame:
        """Frame of that number of the tour in a directory. files: the tour's."""
        pose = CameraPose(*camera.position, camera.yaw_deg, camera.horizon_deg)
        frame = RecordedFrame(None, None, pose, camera.field_of_view_deg)
        read_later = vars(frame)
        del read_later["rgb"], read_later["depth"]
        read_later["_of"] = directory, number, files
        return frame

    @cached_property
    def rgb(self) -> np.ndarray:
        """(H, W, 3) uint8. TourError that names the file where it cannot be read; so has depth."""
        return rgb(*self._of)

    @cached_property
    def depth(self) -> np.ndarray:
        """(H, W) float32, metres along the optical axis."""
        return depth(*self._of)


class RecordedTour(Sequence[Observation]):
    """The frames of a recorded tour, each read from its files when it is looked at."""

    def __init__(self, directory: Path, field_of_view_deg: float) -> None:
        self._directory, self._field_of_view_deg = directory, field_of_view_deg

    @cached_property
    def _cameras(self) -> list[Camera]:
        return cameras(self._directory, self._field_of_view_deg)

    @cached_property
    def _files(self) -> VisitFiles:
        return VisitFiles.load(self._directory)

    def __len__(self) -> int:
        return len(self._cameras)

    @overload
    def __getitem__(self, index: int) -> Observation: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Observation, ...]: ...
    def __getitem__(self, index: int | slice) -> Observation | tuple[Observation, ...]:
        """Raises TourError that names the file of a recording that cannot be read."""
        if isinstance(index, slice):
            return tuple(self[i] for i in range(*index.indices(len(self))))
        number = range(len(self))[index]
        return RecordedFrame.of(self._directory, number, self._files, self._cameras[number])


class RecordedVisit(Visit):
    """A visit that was recorded. Nothing of it is read before its first use: an agent that asks for nothing costs nothing."""

    __slots__ = ()

    def __init__(self, tour: RecordedTour, reachable: np.ndarray) -> None:
        object.__setattr__(self, "observations", tour)
        object.__setattr__(self, "reachable", reachable)

    @property
    def content(self) -> str:
        """See `Visit`. TourError where no tour is recorded."""
        assert isinstance(self.observations, RecordedTour)
        return content(self.observations._directory, self.observations._field_of_view_deg)


def recorded(directory: Path, field_of_view_deg: float, reachable: np.ndarray) -> Visit:
    """The visit that was recorded in a directory (``ovman.sim.visit``), with the positions (K, 2) that can be reached in it.

    Its first use raises TourError where no tour is recorded.
    """
    return RecordedVisit(RecordedTour(directory, field_of_view_deg), reachable)


@lru_cache(maxsize=256)
def content(directory: Path, field_of_view_deg: float) -> str:
    """Digest of a recorded tour's frames and cameras: equal for tours that look the same."""
    return digest(directory, field_of_view_deg, "")
