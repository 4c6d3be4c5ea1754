"""The joint agent with one of its parts replaced by the truth: diagnostics between it and the ideal observer."""

from __future__ import annotations

import math

import numpy as np

from ovman.agents.interface import VISITS, Abstention, Answer, PredictionContext, Query, Relation
from ovman.agents.joint import Joint
from ovman.agents.joint.agent import recorded_segments
from ovman.agents.joint.decision import Nouns, Objects, answer, counterpart_log_odds, decide, group_objects
from ovman.perception.clusters import ObjectMap
from ovman.records.task import WorldState

SURE = 20.0
"""Log odds of what is known to be true."""


class TrueNames(Nouns):
    """Names of detections by what their masks truly show, in place of the encoder's."""

    def __init__(self, context: PredictionContext, constants: Joint) -> None:
        super().__init__(context.noun, constants)
        self._right: dict[bytes, bool] = {}
        for which in VISITS:
            features = context.detections(which).feature
            # A map with one object per detection: the evaluator says which of its objects are of the category.
            alone = ObjectMap(np.zeros((len(features), 2)), features, (), (), tuple(np.array([k]) for k in range(len(features))))
            right = {*context.true_objects(alone, which)}
            self._right |= {_key(feature): k in right for k, feature in enumerate(features)}

    def log_probability(self, feature: np.ndarray, phrase: str | None) -> np.ndarray:
        """Return 0 for a detection of the category, -SURE for another, and `chance` for a segment without a detection."""
        known = [self._right.get(_key(one)) if one.any() else None for one in feature]
        return np.array([self.chance if right is None else -SURE * (not right) for right in known], float)


def _key(feature: np.ndarray) -> bytes:
    return np.asarray(feature, np.float32).tobytes()


def predict_true_names(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm joint_true_names. Reads joint.*."""
    constants = context.settings.joint
    return answer(query, *recorded_segments(context), TrueNames(context, constants), constants), None


def predict_true_identity(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm joint_true_identity. Reads joint.* and admissibility.tau_m. MOVING compares no identities."""
    constants, relation = context.settings.joint, Relation(query.relation)
    nouns, segments = Nouns(context.noun, constants), recorded_segments(context)
    if relation in (Relation.MOVING, Relation.STABLE):
        return answer(query, *segments, nouns, constants), None
    first, second = (group_objects(seen, query.phrase, nouns, constants) for seen in segments)
    worlds = context.world("first"), context.world("second")
    here, there, own, other = (first, second, *worlds) if relation.past else (second, first, *worlds[::-1])
    elsewhere = counterpart_log_odds(here, there, constants)
    elsewhere = correct_identity(here, elsewhere, own, other, constants, context.settings.admissibility.tau_m)
    sure = constants.model_copy(update={"identity": 1.0})
    return decide(relation, first, second, sure, elsewhere), None


def correct_identity(
    here: Objects, elsewhere: np.ndarray, own: WorldState, other: WorldState, constants: Joint, tau_m: float
) -> np.ndarray:
    """Return log odds (N,) of being elsewhere in the other visit: true where an object is at an instance of the category.

    here: the objects of a visit, N; elsewhere: what the agent thinks of each; own, other: the instances of this visit and of the
    other; tau_m: the displacement from which an instance is elsewhere.
    """
    corrected = elsewhere.copy()
    for k, (x, _, z) in enumerate(here.place.tolist()):
        nearest = min(own, key=lambda one: math.dist(one.position, (x, z)), default=None)
        if nearest is not None and math.dist(nearest.position, (x, z)) <= constants.radius_m:
            moved = nearest.id in other and math.dist(nearest.position, other[nearest.id].position) >= tau_m
            corrected[k] = SURE if moved else -SURE
    return corrected
