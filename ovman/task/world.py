"""World states as a tour recorded them, and as they truly were."""

from __future__ import annotations

from collections.abc import Sequence

from ovman.records.change import MoverRecord
from ovman.records.geometry import Point
from ovman.records.sighting import Sighting
from ovman.records.world_state import Instance, WorldState


def recorded_world(sightings: Sequence[Sighting], category: str, min_mask_px: int) -> WorldState:
    """The instances of `category` with a mask of at least `min_mask_px` pixels in some view of a tour, sorted by id.

    sightings: of instances of that category, in the order of the tour. An instance is where it was last recorded; its track holds
    its floor-plane positions in metres at all its recorded views, in the order of the tour.
    """
    tracks: dict[str, list[Point]] = {}
    for seen in sightings:
        if seen.px >= min_mask_px:
            tracks.setdefault(seen.instance, []).append((seen.x, seen.z))
    return WorldState(tuple(Instance.tracked(k, category, tuple(track)) for k, track in sorted(tracks.items())))


def true_world(world: WorldState, movers: Sequence[MoverRecord]) -> WorldState:
    """The world state with the whole path of every mover of the visit as its track."""
    paths = {mover.instance: mover.path for mover in movers}
    return WorldState(
        tuple(
            Instance.tracked(instance.id, instance.category, paths[instance.id]) if instance.id in paths else instance
            for instance in world
        )
    )
