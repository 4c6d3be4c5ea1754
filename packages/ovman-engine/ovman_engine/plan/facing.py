"""Where the agent looks at the start of a scene.

Floor plans do not record the yaw of the start, but they record which objects were visible from it. World frame as in `floorplan`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ovman_engine.plan.floorplan import Box, FloorPlan

YAWS_DEG = (0.0, 90.0, 180.0, 270.0)
AHEAD = np.array([(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)])
"""(4, 2) unit vectors (x, z) of `YAWS_DEG`"""
SAMPLES = 5
"""Points along each side of an object's footprint that are tested."""
FAR_M = 50.0
"""Length of a view that nothing ends."""


def seen_yaw(plan: FloorPlan) -> float | None:
    """Return the right angle, degrees, from which an image 90 degrees wide shows the objects that are recorded as visible.

    First of all, most of them must be in the image at all; then most of their footprints. None if no object is recorded as
    visible, or none of them tells: the floor is visible from everywhere.
    """
    visible = [o.box for o in plan.objects if o.record["visible"] and o.type != "Floor"]
    if not visible:
        return None
    shares = np.array([_shares(box, plan.start[[0, 2]]) for box in visible])
    scores = [((column > 0).sum(), round(float(column.sum()), 6)) for column in shares.T]
    best = max(scores)
    return YAWS_DEG[scores.index(best)] if best[0] else None


def _shares(box: Box, start: np.ndarray) -> np.ndarray:
    """(4,) share of a box's footprint within 45 degrees of each of `YAWS_DEG`, seen from `start` (2,)."""
    low, high = box.bounds()
    axes = [np.linspace(low[i], high[i], SAMPLES) for i in (0, 2)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2) - start
    along, across = points @ AHEAD.T, points @ np.roll(AHEAD, 1, axis=0).T
    return ((along > 0) & (np.abs(across) < along)).mean(axis=0)


def open_yaw(eye: np.ndarray, boxes: Sequence[Box]) -> float:
    """Return the right angle, degrees, with the longest free view among `boxes` from `eye` (3,), metres.

    Of equal ones the first of 0, 90, 180 and 270. Boxes around the eye end no view; turned boxes count as the boxes around them.
    """
    lengths = np.full(len(AHEAD), FAR_M)
    for box in boxes:
        low, high = box.bounds()
        if not low[1] < eye[1] < high[1]:
            continue
        near, far = low[[0, 2]] - eye[[0, 2]], high[[0, 2]] - eye[[0, 2]]
        for k, ahead in enumerate(AHEAD):
            axis = int(np.abs(ahead).argmax())
            distance = near[axis] if ahead[axis] > 0 else -far[axis]
            if near[1 - axis] < 0 < far[1 - axis] and distance > 0:
                lengths[k] = min(lengths[k], distance)
    return YAWS_DEG[int(np.round(lengths, 6).argmax())]
