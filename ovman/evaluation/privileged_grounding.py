"""Grounding by the truth over an agent's own map objects, for diagnostic arms.

It needs the true positions of instances; an agent proper grounds with ``ovman.agents.reference.grounding``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ovman.agents.reference.association import distances, positions
from ovman.models.sighting import Sighting


def grounding_by_truth(recorded: ArrayLike, p: ArrayLike, radius_m: float) -> tuple[int, ...]:
    """The sorted indices of the map objects that stand for true instances.

    recorded (T, 2): every floor-plane position, metres, at which an instance of the category was recorded in a visit; p (N, 2):
    positions of the objects of that visit's map. Each recorded position names the object nearest to it, if that is at most
    radius_m away; of objects equally near the one of smallest x, then z. Raises ValueError for a wrong shape or a value that is
    not finite. Source: Table static, "grounding handed over".
    """
    recorded, p = positions(recorded, "recorded"), positions(p, "p")
    if not len(recorded) or not len(p):
        return ()
    order = np.lexsort(p.T[::-1])
    gap = distances(recorded, p[order])
    nearest = gap.argmin(axis=1)
    return tuple(sorted({int(order[j]) for t, j in enumerate(nearest) if gap[t, j] <= radius_m}))


def recorded_positions(sightings: Sequence[Sighting], min_mask_px: int) -> np.ndarray:
    """(T, 2) floor-plane positions in metres at which a tour recorded the instances, with masks of at least min_mask_px.

    sightings: those of one category in one visit (`ovman.models.visit.Visit.sightings`).
    """
    return positions([(seen.x, seen.z) for seen in sightings if seen.px >= min_mask_px], "recorded")
