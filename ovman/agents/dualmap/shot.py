"""The objects of one frame, independent of the walks that share it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True, eq=False)
class FrameObject:
    """One object in a frame.

    feature (K,): of unit length; confidence: of the detector; clouds: for every run the drawn points (N, 3) float32, world frame,
    metres; mask: (H, W) bool of the frame, None where it is not kept.
    """

    class_id: int
    feature: np.ndarray
    confidence: float
    clouds: tuple[np.ndarray, ...]
    mask: np.ndarray | None = None

    @property
    def box(self) -> np.ndarray:
        """(6,): least x, y, z and greatest x, y, z of the points of all runs."""
        points = np.concatenate(self.clouds)
        return np.concatenate([points.min(axis=0), points.max(axis=0)])


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """The objects in a frame. top_m: height of the top of the frame, metres."""

    seen: tuple[FrameObject, ...]
    top_m: float


def without_ceiling(shot: Shot, ceiling_m: float, margin_m: float) -> Shot:
    """The shot without objects whose box has its middle within a margin of the height of the ceiling."""
    return Shot(tuple(one for one in shot.seen if below_ceiling(one, ceiling_m, margin_m)), shot.top_m)


def below_ceiling(one: FrameObject, ceiling_m: float, margin_m: float) -> bool:
    """Whether the middle of an object's box is farther than a margin from the height of the ceiling."""
    return bool(abs((one.box[1] + one.box[4]) / 2 - ceiling_m) >= margin_m)
