"""The joint agent with one of its parts replaced by the truth: diagnostics between it and the ideal observer."""

from __future__ import annotations

import math

import numpy as np

from ovman.agents.interface import VISITS, Abstention, Answer, PredictionContext, Query
from ovman.agents.joint import Joint
from ovman.agents.joint.agent import recorded_segments
from ovman.agents.joint.decision import Nouns, Objects, answer, compare_objects
from ovman.agents.joint.segments import weigh_tours
from ovman.agents.sharing import keep_last
from ovman.perception.clusters import ObjectMap
from ovman.records.task import Instance, WorldState

SURE = 20.0
"""Log odds of what is known to be true."""


class TrueNames(Nouns):
    """Names of detections by what their masks truly show, in place of the encoder's and believed as much as a sure one of it."""

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
        """Return the most that an embedding can have for a detection of the category, the least for another, else `chance`."""
        known = [self._right.get(_key(one)) if one.any() else None for one in feature]
        astray = self._constants.astray
        of = {None: self.chance, True: math.log1p(astray * (math.exp(self.chance) - 1)), False: math.log(astray) + self.chance}
        return np.array([of[right] for right in known], float)


def _key(feature: np.ndarray) -> bytes:
    return np.asarray(feature, np.float32).tobytes()


def predict_true_names(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm joint_true_names. Reads joint.*."""
    constants = context.settings.joint
    return answer(query, *recorded_segments(context), TrueNames(context, constants), constants), None


def predict_true_boxes(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm joint_true_boxes: from the true masks of what can be moved, named by the encoder."""
    constants = context.settings.joint
    first, second = (context.tour(which) for which in VISITS)
    in_first, in_second = (context.true_detections(which) for which in VISITS)
    segments = _weigh_tours(first, second, in_first, in_second, constants)
    return answer(query, *segments, Nouns(context.noun, constants), constants), None


_weigh_tours = keep_last(weigh_tours)


def predict_true_identity(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm joint_true_identity. Reads joint.* and admissibility.tau_m. MOVING compares no identities."""
    return _answer_with_identity(query, context, Nouns(context.noun, context.settings.joint))


def predict_true_names_and_identity(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm joint_true_names_and_identity. Reads joint.* and admissibility.tau_m."""
    return _answer_with_identity(query, context, TrueNames(context, context.settings.joint))


def _answer_with_identity(query: Query, context: PredictionContext, nouns: Nouns) -> tuple[Answer | Abstention, None]:
    worlds, tau_m = (context.world("first"), context.world("second")), context.settings.admissibility.tau_m

    def compare(first: Objects, second: Objects, constants: Joint) -> np.ndarray:
        same = compare_objects(first, second, constants)
        correct_identity(same, first, second, worlds, constants, tau_m)
        return same

    return answer(query, *recorded_segments(context), nouns, context.settings.joint, compare), None


def correct_identity(
    same: np.ndarray,
    first: Objects,
    second: Objects,
    worlds: tuple[WorldState, WorldState],
    constants: Joint,
    tau_m: float,
) -> None:
    """Correct the log odds (N, M) of being one instance that moved, in place, where both objects are at instances of the noun.

    worlds: the instances of both visits; tau_m: the displacement from which an instance is elsewhere.
    """
    seen, again = (_instances_at(*pair, constants.radius_m) for pair in zip((first, second), worlds, strict=True))
    for i, before in seen.items():
        for j, after in again.items():
            moved = before.id == after.id and math.dist(before.position, after.position) >= tau_m
            same[i, j] = SURE if moved else -SURE


def _instances_at(objects: Objects, world: WorldState, radius_m: float) -> dict[int, Instance]:
    """Return the instance of a world that each object is at, by the object's number; objects at none are left out."""
    found = {}
    for k, (x, _, z) in enumerate(objects.place.tolist()):
        nearest = min(world, key=lambda one: math.dist(one.position, (x, z)), default=None)
        if nearest is not None and math.dist(nearest.position, (x, z)) <= radius_m:
            found[k] = nearest
    return found
