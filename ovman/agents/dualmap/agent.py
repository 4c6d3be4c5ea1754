"""The arms on DualMap's maps: one map maintained through both visits, or one map per visit read by the reference agent's rules.

A maintained map describes the current state. It holds former and present places together without telling them apart, so it
answers every relation with the object that fits the noun best, as DualMap answers a query. With oracle grounding it gets the
objects that stand for instances of the category at their places in both visits; the places of one visit would reveal what has
come or gone. Its success is then the expectation over a uniform pick among these objects. This agrees with the published table:
the rates of this row are whole numbers of successes in three runs with own grounding, and are not with oracle grounding.
"""

from __future__ import annotations

import numpy as np

from ovman.agents.dualmap.mapped import RunMaps, read
from ovman.agents.interface import VISITS, Abstention, AbstentionReason, Answer, PredictionContext, Query, UniformPick
from ovman.agents.reference.reasoning import answer_query, similarities
from ovman.perception.clusters import ObjectMap
from ovman.settings import Need


def predict_maintained(query: Query, context: PredictionContext) -> tuple[Answer | UniformPick | Abstention, None]:
    """Answer as the static arms dualmap_maintained and grounding_dualmap_maintained.

    Own grounding: the centre of the most similar object, the first saved one in a tie. Oracle grounding: a pick among the true
    objects by the observations of both visits. Abstains with NOTHING_GROUNDED without such an object.
    """
    found = _maps(context).maintained[context.visits.first, context.visits.second].object_map()
    if not context.privileged_grounding:
        return pick_most_similar(found, context.noun(query.phrase)), None
    return pick_any(found, {*context.true_objects(found, *VISITS)}), None


def predict_two_visits(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arms dualmap_two_visits and grounding_dualmap_two_visits, by the reference agent's rules.

    A map has one place per object, the centre of its box. The answer to MOVING is the place of the new object that was seen last.
    """
    visits = _maps(context).visits
    map_1, map_2 = (visits[context.visits[which]].object_map() for which in VISITS)
    return answer_query(query, context, map_1, map_2)[0], None


def pick_most_similar(found: ObjectMap, phrase: np.ndarray) -> Answer:
    """Return the place of the object whose feature is most similar to a noun (K,)."""
    x, z = found.p[int(similarities(found.f, phrase).argmax())]
    return Answer(float(x), float(z))


def pick_any(found: ObjectMap, meant: set[int]) -> UniformPick | Abstention:
    """Return the places of the objects of these indices, equally likely; NOTHING_GROUNDED without any."""
    if not meant:
        return Abstention(AbstentionReason.NOTHING_GROUNDED)
    return UniformPick(tuple(sorted((float(x), float(z)) for x, z in found.p[sorted(meant)])))


def _maps(context: PredictionContext) -> RunMaps:
    return context.made(Need.DUALMAP, read)[context.run]
