"""The arms on DynaMem's memory: one memory of both tours, or a memory of each that is read by the reference agent's rules.

The memory of both tours holds the present state. It does not know when something came or what was there before, so it answers
every relation with the best place for the noun, as DynaMem answers a query, or abstains if the place is not confirmed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ovman.agents.dynamem import Dynamem
from ovman.agents.dynamem.memory import Look, Memory, remember_tours
from ovman.agents.interface import VISITS, Abstention, AbstentionReason, Answer, PredictionContext, Query
from ovman.agents.pilot import Executor
from ovman.agents.reference.reasoning import answer_two_visits, ground, similarities
from ovman.agents.words import understands
from ovman.perception.clusters import ObjectMap


@understands
def predict_current(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm dynamem_current, from one memory of both tours. Reads dynamem.*."""
    constants = context.settings.dynamem
    both = remember_tours([(context.tour(which), context.detections(which)) for which in VISITS], constants)
    return locate(*both, context.noun(query.phrase), constants), None


@understands
def predict_two_visits(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm dynamem_two_visits: the reference agent's rules on what the noun means in a memory of each tour.

    Reads dynamem.*, grounding.similarity_margin, association.* and admissibility.tau_m. An object has one place, so the answer to
    MOVING is the place of the new object that was seen last.
    """
    phrase, settings = context.noun(query.phrase), context.settings
    memories = [remember_tours([(context.tour(which), context.detections(which))], settings.dynamem)[0] for which in VISITS]
    map_1, map_2 = (map_noun(one, phrase, settings.grounding.similarity_margin, settings.dynamem) for one in memories)
    return answer_two_visits(query.relation, map_1, map_2, range(len(map_1)), range(len(map_2)), settings)[0], None


class DynamemAgent(Executor):
    """The arm dynamem_current_embodied: drives to the place that the memory of both tours has for the noun."""

    def predict(self, query: Query) -> Answer | Abstention:
        """Remember both tours and locate the noun."""
        constants, tours = self.context.settings.dynamem, (self.first, self.second)
        both = remember_tours([(tour, self.context.detections(tour)) for tour in tours], constants)
        return locate(*both, self.context.noun(query.phrase), constants)


def locate(memory: Memory, frames: Sequence[Look], phrase: np.ndarray, constants: Dynamem) -> Answer | Abstention:
    """Return the place that the memory of `frames` has for a noun (K,).

    The most similar voxel, the first in a tie, names the frame that saw it last. The answer is the place of that frame's most
    similar detection, among those that are similar enough and near enough; without one the place of the voxel, if that is
    similar enough. Else, and with an empty memory, it abstains with NOTHING_GROUNDED.
    """
    if not len(memory):
        return Abstention(AbstentionReason.NOTHING_GROUNDED)
    cosines = similarities(_unit(memory.feature), phrase)
    best = int(cosines.argmax())
    frame = frames[int(memory.seen[best])]
    named = similarities(frame.features, phrase)
    confirmed = np.flatnonzero((named >= constants.similarity) & (frame.nearest_m < constants.detected_m))
    if len(confirmed):
        chosen = min(confirmed.tolist(), key=lambda k: (-named[k], *frame.places[k]))
        return _answer(frame.places[chosen])
    if cosines[best] > constants.similarity:
        return _answer(memory.point[best])
    return Abstention(AbstentionReason.NOTHING_GROUNDED)


def map_noun(memory: Memory, phrase: np.ndarray, similarity_margin: float, constants: Dynamem) -> ObjectMap:
    """Return the objects of a memory that a noun (K,) means: groups of neighbouring voxels nearly as similar as the best one.

    Place and feature of an object are the means of its voxels', and it was last seen when the latest of them was.
    """
    if not len(memory):
        return ObjectMap.of(())
    features = _unit(memory.feature)
    chosen = np.array(ground(features, phrase, similarity_margin), np.int64)
    groups = _group(memory.point[chosen], constants.cluster_voxels * constants.voxel_m)
    members = [chosen[groups == group] for group in range(groups.max() + 1)]
    places = np.array([memory.point[mine][:, [0, 2]].mean(axis=0) for mine in members])
    return ObjectMap(
        p=places,
        f=_unit(np.array([features[mine].mean(axis=0) for mine in members])),
        tracks=tuple(places[:, None]),
        last_seen=tuple(int(memory.seen[mine].max()) for mine in members),
    )


def _group(points: np.ndarray, radius_m: float) -> np.ndarray:
    """Return the numbers (N,) of the groups that points (N, 3) form if neighbours within a radius belong together."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    near = cKDTree(points).query_pairs(radius_m, output_type="ndarray")
    links = coo_matrix((np.ones(len(near), bool), (near[:, 0], near[:, 1])), shape=(len(points), len(points)))
    groups: np.ndarray = connected_components(links, directed=False)[1]
    return groups


def _unit(features: np.ndarray) -> np.ndarray:
    unit: np.ndarray = features / np.maximum(np.linalg.norm(features, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    return unit


def _answer(point: np.ndarray) -> Answer:
    return Answer(float(point[0]), float(point[2]))
