"""What is measured where an agent stops (the terms of Eq. 4)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Measurement:
    """What is measured where an agent stops, metres and pixels.

    box_distance_m: from the stop p to the target's axis-aligned box; answer_distance_m: |p - a|; navigable_distance_m: |p -
    nu(a)|, to the navigable cell of the spawn's component that is nearest to the answer; visible_px: size of the target's mask
    at each pitch of the look-down sweep, keyed by the pitch in degrees. Box and masks are None where no object is left to
    measure them on. Raises ValueError for a negative distance or one that is not a number.
    """

    box_distance_m: float | None
    answer_distance_m: float
    navigable_distance_m: float
    visible_px: Mapping[int, int] | None

    def __post_init__(self) -> None:
        for name in ("box_distance_m", "answer_distance_m", "navigable_distance_m"):
            value = getattr(self, name)
            if value is not None and not value >= 0.0:
                raise ValueError(f"{name} is {value}: a distance is at least 0")
