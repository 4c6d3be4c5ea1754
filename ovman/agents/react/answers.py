"""The arms on REACT's output: what is matched, absent and new, read by relation among what the noun means.

The output says what became of every instance and knows no noun. The noun means what it means to the reference agent, in either
visit, and a matched pair is meant where one of its ends is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ovman.agents.interface import (
    VISITS,
    Abstention,
    AbstentionReason,
    AgentContext,
    Answer,
    Evidence,
    PredictionContext,
    Query,
    Relation,
)
from ovman.agents.react.instances import class_features, instances
from ovman.agents.react.matching import matched
from ovman.agents.reference.association import Association, distances
from ovman.agents.reference.decision import decide, moving_by_last_sighting
from ovman.agents.reference.grounding import grounded
from ovman.agents.reference.reasoning import means_of
from ovman.agents.reference.two_visits import ReferenceAgent
from ovman.perception.object_map import ObjectMap
from ovman.settings import Settings


def predict_two_visits(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, Evidence]:
    """The static arms. Reads react.*, grounding.similarity_margin, admissibility.tau_m and association.track_spread_m."""
    map_1, map_2 = (context.map(which) for which in VISITS)
    meant = [means_of(query, context, objects, which) for which, objects in zip(VISITS, (map_1, map_2), strict=True)]
    return answered(query.relation, map_1, map_2, *meant, embedding=context.noun, settings=context.settings)


def answered(
    relation: Relation,
    map_1: ObjectMap,
    map_2: ObjectMap,
    meant_1: Sequence[int],
    meant_2: Sequence[int],
    *,
    embedding: Callable[[str], np.ndarray],
    settings: Settings,
) -> tuple[Answer | Abstention, Evidence]:
    """The answer from the maps of two visits, and its evidence. meant_1, meant_2: what the noun means in each.

    embedding: of the names of classes, (K,). Abstains with NOTHING_GROUNDED where the noun means nothing in either visit, and as
    ``read`` does.
    """
    if not meant_1 and not meant_2:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), Evidence((), ())
    classes = class_features(embedding)
    first, second = (instances(objects, classes) for objects in (map_1, map_2))
    found = among(matched(first, second, settings.react.appearance), meant_1, meant_2)
    of_1 = tuple(sorted({*found.unmatched_1, *(i for i, _ in found.pairs)}))
    of_2 = tuple(sorted({*found.unmatched_2, *(j for _, j in found.pairs)}))
    return read(relation, map_1, map_2, found, settings), Evidence(of_1, of_2, found.pairs)


def among(output: Association, meant_1: Sequence[int], meant_2: Sequence[int]) -> Association:
    """Of REACT's output, what the noun means."""
    return Association(
        pairs=tuple((i, j) for i, j in output.pairs if i in meant_1 or j in meant_2),
        unmatched_1=tuple(i for i in output.unmatched_1 if i in meant_1),
        unmatched_2=tuple(j for j in output.unmatched_2 if j in meant_2),
    )


def read(relation: Relation, map_1: ObjectMap, map_2: ObjectMap, found: Association, settings: Settings) -> Answer | Abstention:
    """The answer to a relation. `found`: of the maps' objects, those that the noun means.

    A matched instance has moved from a travelled distance of tau_m on. MOVED, FORMER: the matched one that moved farthest;
    without one a new, or an absent one, whose match was missed. APPEARED: a new one. REMOVED: an absent one. STABLE: the matched
    one that moved least, if it has not moved. MOVING: of the new and the moved ones the one that was seen last. Of several new or
    absent ones the one farthest from the other visit's. Abstains as the reference agent's rules do.
    """
    if Relation(relation) is Relation.MOVING:
        apart = distances(map_1.p, map_2.p)
        moved = {j for i, j in found.pairs if apart[i, j] >= settings.admissibility.tau_m}
        afoot = Association((), (), tuple(sorted({*found.unmatched_2} | moved)))
        return moving_by_last_sighting(map_2.tracks, map_2.last_seen, afoot)
    if Relation(relation) in (Relation.MOVED, Relation.FORMER):
        outcome = _decided(relation, map_1, map_2, Association(found.pairs, (), ()), settings)
        if isinstance(outcome, Answer) or not (found.unmatched_2 if relation is Relation.MOVED else found.unmatched_1):
            return outcome
    return _decided(relation, map_1, map_2, found, settings)


def _decided(
    relation: Relation, map_1: ObjectMap, map_2: ObjectMap, found: Association, settings: Settings
) -> Answer | Abstention:
    """What the reference agent decides on the objects of `found` alone."""
    of_1 = sorted({*found.unmatched_1, *(i for i, _ in found.pairs)})
    of_2 = sorted({*found.unmatched_2, *(j for _, j in found.pairs)})
    number_1, number_2 = ({index: n for n, index in enumerate(of)} for of in (of_1, of_2))
    renumbered = Association(
        pairs=tuple((number_1[i], number_2[j]) for i, j in found.pairs),
        unmatched_1=tuple(number_1[i] for i in found.unmatched_1),
        unmatched_2=tuple(number_2[j] for j in found.unmatched_2),
    )
    return decide(
        relation,
        map_1.p[of_1],
        map_2.p[of_2],
        renumbered,
        (),
        tau_m=settings.admissibility.tau_m,
        track_spread_m=settings.association.track_spread_m,
    )


class ReactAgent(ReferenceAgent):
    """REACT's matching of both visits. It takes no images while it drives."""

    def _decided(self, query: Query, phrase: np.ndarray) -> Answer | Abstention:
        margin = self._settings.grounding.similarity_margin
        meant = [grounded(objects.f, phrase, margin) for objects in (self._first, self._second)]
        return answered(query.relation, self._first, self._second, *meant, embedding=self._nouns, settings=self._settings)[0]


def agent(context: AgentContext) -> ReactAgent:
    """The embodied arm."""
    return ReactAgent(context.pilot, context.mapper, context.noun, context.settings)
