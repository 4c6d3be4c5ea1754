"""Whether a query may be released (Eq. 2 and the condition that follows it)."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass

from ovman.records.query import Query
from ovman.records.rejection import Rejection
from ovman.records.world_state import WorldState, displacement_m
from ovman.settings import Settings
from ovman.task.referents import referents


@dataclass(frozen=True, slots=True)
class Inadmissible:
    """Why a query may not be released, and the sorted ids of the instances at fault (none where the referent is absent)."""

    reason: Rejection
    instances: tuple[str, ...] = ()


def admissible(
    world_1: WorldState,
    world_2: WorldState,
    query: Query,
    changed: Set[str],
    constants: Settings,
    target: str | None = None,
) -> Inadmissible | None:
    """None if the query may be released on these two recorded states, else the first reason why not.

    Eq. 2: the referent is unique (REFERENT_ABSENT, REFERENT_AMBIGUOUS). Where a `target` is named, the referent is that
    instance (REFERENT_NOT_TARGET): otherwise an unscripted event would answer the query. No instance of the category other than
    the referent and the `changed` ones moves by more than tau between the visits (BYSTANDER_MOVED). For STABLE it is a
    distractor that has to move; it is the scripted change and so among `changed`.
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
