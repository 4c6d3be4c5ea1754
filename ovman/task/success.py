"""Success at a stop (Eq. 4) and its weighting by path length (Eq. 5)."""

from __future__ import annotations

import math

from ovman.records.measurement import Measurement
from ovman.records.relation import Relation
from ovman.settings.benchmark import Success


def visible(measurement: Measurement, constants: Success) -> bool:
    """vis(o_k): the target's mask covers at least visible_px pixels at some pitch of the sweep.

    Pitches beside those of the sweep do not count. A target that is gone is not visible. ValueError where a pitch of the sweep
    was not measured.
    """
    if measurement.visible_px is None:
        return False
    missing = [pitch for pitch in constants.sweep_deg if pitch not in measurement.visible_px]
    if missing:
        measured = sorted(measurement.visible_px)
        raise ValueError(f"the sweep {list(constants.sweep_deg)} needs the pitches {missing}, only {measured} were measured")
    return any(measurement.visible_px[pitch] >= constants.visible_px for pitch in constants.sweep_deg)


def success(measurement: Measurement, relation: Relation, constants: Success) -> bool:
    """Eq. 4. Current relations: the box or the navigable cell of the answer within R, and the target visible. Past relations: the
    answer or its navigable cell within R; nothing is there to see."""
    if relation.past:
        return min(measurement.answer_distance_m, measurement.navigable_distance_m) <= constants.radius_m
    box_distance_m = math.inf if measurement.box_distance_m is None else measurement.box_distance_m
    near = min(box_distance_m, measurement.navigable_distance_m) <= constants.radius_m
    return near and visible(measurement, constants)


def spl(success: bool, shortest_m: float, travelled_m: float) -> float:
    """Eq. 5, S L* / max(L*, L), in [0, 1]. Both lengths in metres; an agent that need not and does not move has travelled a
    shortest path, so 0/0 counts as 1. Raises ValueError for a negative length or one that is not a number."""
    if not (shortest_m >= 0.0 and travelled_m >= 0.0):
        raise ValueError(f"path lengths {shortest_m} and {travelled_m} m: a length is at least 0")
    if not success:
        return 0.0
    longest_m = max(shortest_m, travelled_m)
    return shortest_m / longest_m if longest_m > 0.0 else 1.0
