"""Where a query is answered (Eq. 3)."""

from __future__ import annotations

from ovman.records.geometry import Point
from ovman.records.query import Query
from ovman.records.relation import Relation
from ovman.records.world_state import WorldState


def answer(world_1: WorldState, world_2: WorldState, query: Query, referent: str, mover_at: Point | None = None) -> Point:
    """a_t(q): floor-plane position (x, z) in metres that answers `query`, whose unique referent is `referent`.

    mover_at: where the mover is at step t, for MOVING; without it the answer is the mover's last position in visit 2. It is
    read for no other relation, since their answers are fixed. KeyError if the referent is absent from the visit that the
    relation reads.
    """
    if query.relation.past:
        return world_1[referent].position
    if query.relation is Relation.MOVING and mover_at is not None:
        return mover_at
    return world_2[referent].position
