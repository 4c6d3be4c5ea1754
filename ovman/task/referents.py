"""Which instances a query selects (Eq. 1)."""

from __future__ import annotations

from ovman.records.query import Query
from ovman.records.relation import Relation
from ovman.records.world_state import WorldState, displacement_m
from ovman.settings import Settings


def holds(relation: Relation, instance_id: str, world_1: WorldState, world_2: WorldState, constants: Settings) -> bool:
    """Whether Eq. 1's predicate of `relation` holds for an instance.

    The predicates are not exclusive: an instance that moves during visit 2 may also have moved between the visits. The
    displacement of such an instance is taken to its last position.
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


def referents(world_1: WorldState, world_2: WorldState, query: Query, constants: Settings) -> tuple[str, ...]:
    """Sorted ids of the instances of the query's category for which its relation holds: the set of Eq. 2."""
    of_category = {instance.id for world in (world_1, world_2) for instance in world.category(query.category)}
    return tuple(sorted(k for k in of_category if holds(query.relation, k, world_1, world_2, constants)))


def _another_moved(instance_id: str, world_1: WorldState, world_2: WorldState, constants: Settings) -> bool:
    category = world_2[instance_id].category
    return any(
        holds(Relation.MOVED, other.id, world_1, world_2, constants)
        for other in world_2.category(category)
        if other.id != instance_id
    )
