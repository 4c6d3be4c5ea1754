"""The task: relations (Eq. 1), admissibility (Eq. 2), answer (Eq. 3), success (Eq. 4), SPL (Eq. 5). Pure functions of records."""

from __future__ import annotations

import math
from collections.abc import Sequence, Set
from dataclasses import dataclass

from ovman.records.geometry import Point
from ovman.records.scene import MoverRecord
from ovman.records.task import Instance, Measurement, Query, Rejection, Relation, WorldState, displacement_m
from ovman.records.visit import Sighting
from ovman.settings import Settings
from ovman.settings.benchmark import Success


def recorded_world(sightings: Sequence[Sighting], category: str, min_mask_px: int) -> WorldState:
    """Return the instances of a category with a mask of at least `min_mask_px` pixels in some view of a tour, sorted by id.

    sightings: of instances of that category, in the order of the tour. An instance is where it was last recorded; its track holds
    its floor-plane positions in metres at all its recorded views, in the order of the tour.
    """
    tracks: dict[str, list[Point]] = {}
    for seen in sightings:
        if seen.px >= min_mask_px:
            tracks.setdefault(seen.instance, []).append((seen.x, seen.z))
    return WorldState(tuple(Instance.tracked(k, category, tuple(track)) for k, track in sorted(tracks.items())))


def true_world(world: WorldState, movers: Sequence[MoverRecord]) -> WorldState:
    """Return a world state with the whole path of every mover of the visit as its track."""
    return world.with_tracks({mover.instance: mover.path for mover in movers})


def holds(relation: Relation, instance_id: str, world_1: WorldState, world_2: WorldState, constants: Settings) -> bool:
    """Return whether Eq. 1's predicate of a relation holds for an instance.

    The predicates are not exclusive: an instance that moves during visit 2 may also have moved between the visits. Its
    displacement is measured to its last position.
    """
    in_1, in_2 = instance_id in world_1, instance_id in world_2
    match relation:
        case Relation.APPEARED:
            return in_2 and not in_1
        case Relation.REMOVED:
            return in_1 and not in_2
        case Relation.MOVING:
            return in_2 and world_2[instance_id].extent_m > constants.admissibility.motion_m
    displacement = displacement_m(world_1, world_2, instance_id)
    if displacement is None:
        return False
    if relation is Relation.STABLE:
        return displacement < constants.admissibility.tau_m and _another_moved(instance_id, world_1, world_2, constants)
    return displacement >= constants.candidates.delta_min_m


def _another_moved(instance_id: str, world_1: WorldState, world_2: WorldState, constants: Settings) -> bool:
    category = world_2[instance_id].category
    return any(
        holds(Relation.MOVED, other.id, world_1, world_2, constants)
        for other in world_2.category(category)
        if other.id != instance_id
    )


def referents(world_1: WorldState, world_2: WorldState, query: Query, constants: Settings) -> tuple[str, ...]:
    """Return the sorted ids of the instances of the query's category for which its relation holds: the set of Eq. 2."""
    of_category = {instance.id for world in (world_1, world_2) for instance in world.category(query.category)}
    return tuple(sorted(k for k in of_category if holds(query.relation, k, world_1, world_2, constants)))


@dataclass(frozen=True, slots=True)
class Inadmissible:
    """Why a query may not be released, and the sorted ids of the instances at fault (none if the referent is absent)."""

    reason: Rejection
    instances: tuple[str, ...] = ()


def admissible(
    world_1: WorldState, world_2: WorldState, query: Query, changed: Set[str], constants: Settings, target: str | None = None
) -> Inadmissible | None:
    """Return None if a query may be released on two recorded states, else the first reason against it.

    Eq. 2: the referent is unique (REFERENT_ABSENT, REFERENT_AMBIGUOUS). If a `target` is named, the referent is that instance
    (REFERENT_NOT_TARGET): otherwise an unscripted event would answer the query. No instance of the category other than the
    referent and the `changed` ones moves by more than tau between the visits (BYSTANDER_MOVED). For STABLE a distractor has to
    move; that is the scripted change, so the distractor is among `changed`.
    """
    selected = referents(world_1, world_2, query, constants)
    if len(selected) != 1:
        return Inadmissible(Rejection.REFERENT_AMBIGUOUS if selected else Rejection.REFERENT_ABSENT, selected)
    if target is not None and selected != (target,):
        return Inadmissible(Rejection.REFERENT_NOT_TARGET, selected)
    excused, tau_m = {*selected, *changed}, constants.admissibility.tau_m
    moved = tuple(
        sorted(
            instance.id
            for instance in world_1.category(query.category)
            if instance.id not in excused and (displacement_m(world_1, world_2, instance.id) or 0.0) > tau_m
        )
    )
    return Inadmissible(Rejection.BYSTANDER_MOVED, moved) if moved else None


def answer(world_1: WorldState, world_2: WorldState, query: Query, referent: str, mover_at: Point | None = None) -> Point:
    """Return a_t(q) of Eq. 3: the floor-plane position (x, z) in metres that answers a query with a unique referent.

    mover_at: the position of the mover at step t, read for MOVING alone; without it the answer is the mover's last position in
    visit 2. KeyError if the referent is absent from the visit that the relation reads.
    """
    if query.relation.past:
        return world_1[referent].position
    if query.relation is Relation.MOVING and mover_at is not None:
        return mover_at
    return world_2[referent].position


def visible(measurement: Measurement, constants: Success) -> bool:
    """Return vis(o_k): the target's mask covers at least visible_px pixels at some pitch of the sweep.

    Other pitches do not count. An absent target is not visible. ValueError if a pitch of the sweep was not measured.
    """
    if measurement.visible_px is None:
        return False
    missing = [pitch for pitch in constants.sweep_deg if pitch not in measurement.visible_px]
    if missing:
        measured = sorted(measurement.visible_px)
        raise ValueError(f"the sweep {list(constants.sweep_deg)} needs the pitches {missing}, only {measured} were measured")
    return any(measurement.visible_px[pitch] >= constants.visible_px for pitch in constants.sweep_deg)


def success(measurement: Measurement, relation: Relation, constants: Success, exclusive: bool = False) -> bool:
    """Return whether a stop succeeds (Eq. 4).

    Current relations: the box or the navigable cell of the answer is within R, and the target is visible. Past relations: the
    answer or its navigable cell is within R. exclusive: the stop is also nearer to the answer than to any rival. Both are points,
    the centres of boxes on the floor plane. ValueError if the distance to the nearest rival was not measured.
    """
    if exclusive:
        if measurement.rival_distance_m is None:
            raise ValueError("success is exclusive, but the distance to the nearest rival was not measured; make the runs again")
        if measurement.answer_distance_m >= measurement.rival_distance_m:
            return False
    if relation.past:
        return min(measurement.answer_distance_m, measurement.navigable_distance_m) <= constants.radius_m
    box_distance_m = math.inf if measurement.box_distance_m is None else measurement.box_distance_m
    near = min(box_distance_m, measurement.navigable_distance_m) <= constants.radius_m
    return near and visible(measurement, constants)


def spl(success: bool, shortest_m: float, travelled_m: float) -> float:
    """Return S L* / max(L*, L) of Eq. 5, in [0, 1], from lengths in metres.

    An agent that need not move and does not has travelled a shortest path, so 0/0 counts as 1. ValueError for a negative length
    and for NaN.
    """
    if not (shortest_m >= 0.0 and travelled_m >= 0.0):
        raise ValueError(f"path lengths {shortest_m} and {travelled_m} m: a length is at least 0")
    if not success:
        return 0.0
    longest_m = max(shortest_m, travelled_m)
    return shortest_m / longest_m if longest_m > 0.0 else 1.0
