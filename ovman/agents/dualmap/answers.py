"""The arms on DualMap's maps: one map maintained through both visits, or a map of each visit read by OVMAN's own rules.

A maintained map is a reading of the current state. It holds former and present places side by side and cannot tell which is
which, so that it answers every relation alike: with the place of the object that the noun fits best, as DualMap answers a query.
With grounding handed over it is told which of its objects stand for instances of the category, and that at the places of both
visits: places of the second alone would tell it what has left, those of the first what has come. One of these objects is as good
as another, and its success the expectation over a uniform pick. So the published table has it: with its own grounding the rates
of this row are whole numbers of successes in three runs, with grounding handed over they are not.

The two maps of single visits are grounded, associated and decided over as the reference agent's are
(`ovman.agents.reference.reasoning`).
"""

from __future__ import annotations

import numpy as np

from ovman.agents.dualmap.mapped import RunMaps, read
from ovman.agents.interface import VISITS, Abstention, AbstentionReason, Answer, PredictionContext, Query, UniformPick
from ovman.agents.reference.grounding import similarities
from ovman.agents.reference.reasoning import two_visits_recorded
from ovman.language import noun
from ovman.models.settings import Need
from ovman.perception.object_map import ObjectMap


def predict_maintained(query: Query, context: PredictionContext) -> tuple[Answer | UniformPick | Abstention, None]:
    """The static arms dualmap_maintained and grounding_dualmap_maintained.

    Own grounding: the centre of the most similar object, of equally similar ones the first that was saved. Handed grounding: a
    pick among the objects nearest to where either visit recorded an instance, as ``grounding_by_truth`` has it. Abstains with
    NOTHING_GROUNDED where that is none.
    """
    found = _maps(context).maintained[context.visits.first, context.visits.second].object_map()
    if not context.privileged_grounding:
        return most_similar(found, context.noun(noun(query.category))), None
    return any_of(found, {index for which in VISITS for index in context.true_objects(which, found.p)}), None


def predict_two_visits(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arms dualmap_two_visits and grounding_dualmap_two_visits: the reference agent's rules on DualMap's maps.

    A map knows one place of every object, its box's centre, so that MOVING is answered with that of the latest-seen one that is
    new.
    """
    visits = _maps(context).visits
    map_1, map_2 = (visits[context.visits[which]].object_map() for which in VISITS)
    return two_visits_recorded(query, context, map_1, map_2)[0], None


def most_similar(found: ObjectMap, phrase: np.ndarray) -> Answer | Abstention:
    """The place of the object whose feature is most similar to a noun (K,); NOTHING_GROUNDED for an empty map."""
    if not len(found):
        return Abstention(AbstentionReason.NOTHING_GROUNDED)
    x, z = found.p[int(similarities(found.f, phrase).argmax())]
    return Answer(float(x), float(z))


def any_of(found: ObjectMap, meant: set[int]) -> UniformPick | Abstention:
    """The places of the objects of these indices, equally likely; NOTHING_GROUNDED without any."""
    if not meant:
        return Abstention(AbstentionReason.NOTHING_GROUNDED)
    return UniformPick(tuple(sorted((float(x), float(z)) for x, z in found.p[sorted(meant)])))


def _maps(context: PredictionContext) -> RunMaps:
    return context.made(Need.DUALMAP, read)[context.run]
