"""The static arm, and what both arms decide on."""

from __future__ import annotations

from ovman.agents.interface import VISITS, Abstention, Answer, PredictionContext, Query, Relation
from ovman.agents.joint.decision import decide, moving
from ovman.agents.joint.naming import Nouns
from ovman.agents.joint.objects import objects
from ovman.agents.joint.recorded import of_tours, read
from ovman.agents.joint.segments import Segments
from ovman.agents.joint.settings import Joint
from ovman.language import noun
from ovman.settings import Need


def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arm. Reads joint.*."""
    constants = context.settings.joint
    return answer(query, *recorded(context), Nouns(context.noun, constants), constants), None


def recorded(context: PredictionContext) -> tuple[Segments, Segments]:
    """The segments of both recorded visits, as the stage `segments` made them."""
    first, second = VISITS
    return of_tours(context.made(Need.SEGMENTS, read), context.tour(first), context.tour(second))


def answer(query: Query, first: Segments, second: Segments, nouns: Nouns, constants: Joint) -> Answer | Abstention:
    """What is answered from the segments of both visits. Without a category the noun is no evidence."""
    phrase = noun(query.category) if query.category else None
    relation = Relation(query.relation)
    if relation is Relation.MOVING:
        return moving(second, phrase, nouns, constants)
    return decide(relation, objects(first, phrase, nouns, constants), objects(second, phrase, nouns, constants), constants)
