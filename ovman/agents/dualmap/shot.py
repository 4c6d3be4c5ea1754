"""What one frame showed, whichever walks it is a frame of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True, eq=False)
class FrameObject:
    """One object in a frame: its class, its feature (K,) of unit length, how sure the detector was, and of every run the points
    (N, 3) float32 that were drawn of it, world frame, metres."""

    class_id: int
    feature: np.ndarray
    confidence: float
    clouds: tuple[np.ndarray, ...]

    @property
    def box(self) -> np.ndarray:
        """(6,): least x, y, z and greatest x, y, z of the points of all runs."""
        points = np.concatenate(self.clouds)
        return np.concatenate([points.min(axis=0), points.max(axis=0)])


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """The objects in a frame, and top_m, the height of the highest that it shows, metres."""

    seen: tuple[FrameObject, ...]
    top_m: float


def without_ceiling(shot: Shot, ceiling_m: float, margin_m: float) -> Shot:
    """The shot without what has the middle of its box within a margin of the height of the ceiling."""
    return Shot(tuple(one for one in shot.seen if abs((one.box[1] + one.box[4]) / 2 - ceiling_m) >= margin_m), shot.top_m)
