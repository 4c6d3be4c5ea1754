"""World states as the recorded tours show them: an instance counts as recorded where its mask is large enough."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ovman.task import Instance, WorldState


def world_state(sightings: Sequence[Mapping[str, Any]], category: str, minimum_px: int) -> WorldState:
    """The instances of `category` with a mask of at least `minimum_px` in some view of a visit.

    `sightings` are those of `ovman.sim.visit.Visit.sightings`. An instance is where it was last recorded; its track are the
    floor-plane positions (metres) of all its recorded views in the order of the tour.
    """
    tracks: dict[str, list[tuple[float, float]]] = {}
    for seen in sightings:
        if seen["px"] >= minimum_px:
            tracks.setdefault(seen["instance"], []).append((seen["x"], seen["z"]))
    return WorldState(tuple(Instance(k, category, track[-1][0], track[-1][1], tuple(track)) for k, track in sorted(tracks.items())))
