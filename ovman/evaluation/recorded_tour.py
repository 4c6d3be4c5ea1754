"""Recorded tours as an agent is given them: frames and camera poses, and nothing else of the recording."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from pathlib import Path
from typing import overload

import numpy as np

from ovman.agents.interface import CameraPose, Observation, Visit
from ovman.perception.backprojection import Camera
from ovman.perception.tour_files import cameras, digest, view


class RecordedTour(Sequence[Observation]):
    """The frames of a recorded tour, each read from its files when it is indexed."""

    def __init__(self, directory: Path, field_of_view_deg: float) -> None:
        self._directory, self._field_of_view_deg = directory, field_of_view_deg

    @cached_property
    def _cameras(self) -> list[Camera]:
        return cameras(self._directory, self._field_of_view_deg)

    def __len__(self) -> int:
        return len(self._cameras)

    @overload
    def __getitem__(self, index: int) -> Observation: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Observation, ...]: ...
    def __getitem__(self, index: int | slice) -> Observation | tuple[Observation, ...]:
        """Raises TourError that names the file for a picture that cannot be read."""
        if isinstance(index, slice):
            return tuple(self[i] for i in range(*index.indices(len(self))))
        number = range(len(self))[index]
        camera = self._cameras[number]
        seen = view(self._directory, number, camera)
        pose = CameraPose(*camera.position, camera.yaw_deg, camera.horizon_deg)
        return Observation(seen.rgb, seen.depth, pose, camera.field_of_view_deg)


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
