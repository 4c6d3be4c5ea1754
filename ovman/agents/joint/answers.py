"""The static arm, and what both arms decide on."""

from __future__ import annotations

from ovman.agents.interface import VISITS, Abstention, Answer, PredictionContext, Query, Relation, Visit
from ovman.agents.joint.decision import decide, moving
from ovman.agents.joint.naming import Nouns
from ovman.agents.joint.objects import objects
from ovman.agents.joint.segments import Segments, segments
from ovman.agents.joint.sight import frames
from ovman.language import noun
from ovman.models.settings.joint import Joint
from ovman.perception.detected import Detected


def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arm. Reads joint.*."""
    constants = context.settings.joint
    first, second = recorded(context, constants)
    return answer(query, first, second, Nouns(context.noun, constants), constants), None


def recorded(context: PredictionContext, constants: Joint) -> tuple[Segments, Segments]:
    """The segments of both recorded visits."""
    first, second = VISITS
    return evidence(context.tour(first), context.tour(second), context.detections(first), context.detections(second), constants)


def evidence(first: Visit, second: Visit, in_first: Detected, in_second: Detected, constants: Joint) -> tuple[Segments, Segments]:
    """The segments of both visits, which know no query."""
    frames_1, frames_2 = frames(first, constants), frames(second, constants)
    return segments(frames_1, in_first, frames_2, constants), segments(frames_2, in_second, frames_1, constants)


def answer(query: Query, first: Segments, second: Segments, nouns: Nouns, constants: Joint) -> Answer | Abstention:
    """What is answered from the segments of both visits. Without a category the noun is no evidence."""
    phrase = noun(query.category) if query.category else None
    relation = Relation(query.relation)
    if relation is Relation.MOVING:
        return moving(second, phrase, nouns, constants)
    return decide(relation, objects(first, phrase, nouns, constants), objects(second, phrase, nouns, constants), constants)
