"""The input of DualMap's maps: one object in one keyframe."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True, eq=False)
class ObjectObservation:
    """One segmented object of one keyframe.

    frame: index of the keyframe in its walk; class_id: index in the list of classes; confidence: of the detector; feature (K,):
    unit float32, 0.7 of the crop's embedding and 0.3 of the class name's, normalised; clouds: of every run, the points (N, 3)
    float32 that it drew of the mask's pixels, metres in Unity's world frame (x, y up, z), N at least 1; box (6,): least x, y, z
    and greatest x, y, z of the object, metres; low_mobility: it is furniture that seldom moves; number: among all observations of
    its walk.
    """

    frame: int
    class_id: int
    confidence: float
    feature: np.ndarray
    clouds: tuple[np.ndarray, ...]
    box: np.ndarray
    low_mobility: bool
    number: int = 0
