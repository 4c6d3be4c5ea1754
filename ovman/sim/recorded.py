"""From what was recorded to what the task judges: world states as the tours show them, the verdict on a measured run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ovman.models.settings.benchmark import Success
from ovman.task import Instance, Measurement, Relation, WorldState, success

MEASURED = (
    "stop",
    "box_distance_m",
    "answer_distance_m",
    "navigable_distance_m",
    "visible_px",
    "path_length_m",
    "actions",
)
"""What is measured of a run, in the order of the records."""


def world_state(sightings: Sequence[Mapping[str, Any]], category: str, min_mask_px: int) -> WorldState:
    """The instances of `category` with a mask of at least `min_mask_px` in some view of a visit.

    `sightings` are those of `ovman.sim.visit.Visit.sightings`. An instance is where it was last recorded; its track are the
    floor-plane positions (metres) of all its recorded views in the order of the tour.
    """
    tracks: dict[str, list[tuple[float, float]]] = {}
    for seen in sightings:
        if seen["px"] >= min_mask_px:
            tracks.setdefault(seen["instance"], []).append((seen["x"], seen["z"]))
    return WorldState(
        tuple(Instance(k, category, track[-1][0], track[-1][1], tuple(track)) for k, track in sorted(tracks.items()))
    )


def any_instance(run: Mapping[str, Any], constants: Success) -> bool:
    """Whether a measured run ends within R of any instance of the category and with it in sight, the relation aside.

    A run that did not stop is a failure.
    """
    if run["outcome"] != "stopped":
        return False
    return any(
        found["box_distance_m"] <= constants.radius_m
        and any(found["visible_px"][str(pitch)] >= constants.visible_px for pitch in constants.sweep_deg)
        for found in run.get("instances", {}).values()
    )


def judged(run: Mapping[str, Any], relation: Relation, constants: Success) -> bool:
    """Success (Eq. 4) of a measured run; a run that did not stop is a failure."""
    if run["outcome"] != "stopped":
        return False
    pixels = run["visible_px"]
    measurement = Measurement(
        box_distance_m=run["box_distance_m"],
        answer_distance_m=run["answer_distance_m"],
        navigable_distance_m=run["navigable_distance_m"],
        visible_px=None if pixels is None else {int(pitch): px for pitch, px in pixels.items()},
    )
    return success(measurement, relation, constants)
