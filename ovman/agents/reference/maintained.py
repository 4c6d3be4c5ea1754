"""One map that is maintained through both visits, on the reference agent's mapping: a reading that does not tell visits apart.

It holds former and present places side by side, so that every grounded object is as good an answer as the others: a stochastic
pick, whose probability of success the evaluator computes. Source: the paper's Fig. memory, "one current-state reading".
"""

from __future__ import annotations

from ovman.agents.interface import VISITS, Abstention, AbstentionReason, PredictionContext, Query, Relation, UniformPick
from ovman.agents.reference.reasoning import means_of
from ovman.perception.maintained import together
from ovman.perception.object_map import ObjectMap
from ovman.perception.records import read_maps
from ovman.settings import Need


def predict(query: Query, context: PredictionContext) -> tuple[UniformPick | Abstention, None]:
    """The static arms maintained_map and grounding_maintained_map.

    A grounded object is answered with its place, for MOVING with its last track point. Abstains with NOTHING_GROUNDED without
    one.
    """
    name = together(context.visits.first, context.visits.second)
    objects = ObjectMap.of(context.made(Need.MAINTAINED, read_maps)[name])
    meant = means_of(query, context, objects, *VISITS)
    if not meant:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), None
    moving = query.relation is Relation.MOVING
    places = [objects.tracks[i][-1] if moving else objects.p[i] for i in meant]
    return UniformPick(tuple(sorted((float(x), float(z)) for x, z in places))), None
