"""Whether who recognises a category, but not which instance is meant, would still stop at the answer (the anti-shortcut rule)."""

from __future__ import annotations

import math

from ovman.records.geometry import Point
from ovman.records.query import Query
from ovman.records.world_state import WorldState


def crowding(
    world_1: WorldState, world_2: WorldState, query: Query, referent: str, at: Point, radius_m: float
) -> tuple[str, ...]:
    """Sorted ids of the instances of the category, other than the referent, at most `radius_m` from the answer.

    at: the answer, floor plane, metres. Positions are those of the visit that the answer belongs to, the first for past
    relations, and of the second visit, in which an agent walks to the place. A uniform pick of an instance is at chance 1/n
    where none is there and radius_m is that of the success test. ValueError for a negative radius. Source: "an agent that
    recognises the category but not which of the n instances the relation selects is at chance 1/n".
    """
    if not radius_m >= 0.0:
        raise ValueError(f"radius_m must be at least 0, not {radius_m}")
    visits = (world_1, world_2) if query.relation.past else (world_2,)
    return tuple(
        sorted(
            {
                instance.id
                for world in visits
                for instance in world.category(query.category)
                if instance.id != referent and math.dist(instance.position, at) <= radius_m
            }
        )
    )


def category_pick(world: WorldState, query: Query, at: Point, radius_m: float) -> float:
    """Probability that a uniform pick of an instance of the category is at most `radius_m` from the answer; 0 without any.

    world: what is picked from, such as the instances that a tour recorded; at: the answer, floor plane, metres.
    """
    instances = world.category(query.category)
    return sum(math.dist(instance.position, at) <= radius_m for instance in instances) / len(instances) if instances else 0.0
