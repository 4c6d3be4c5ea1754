"""The arms on DynaMem's memory: one memory of both tours, or a memory of each that is read by the reference agent's rules.

The memory of both tours holds the present state. It does not know when something came or what was there before, so it answers
every relation with the best place for the noun, as DynaMem answers a query, or abstains where the place is not confirmed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ovman.agents.dynamem.looks import Look, looks
from ovman.agents.dynamem.memory import Memory, remembered
from ovman.agents.dynamem.settings import Dynamem
from ovman.agents.interface import VISITS, Abstention, AbstentionReason, Answer, PredictionContext, Query, Visit
from ovman.agents.reference.grounding import grounded, similarities
from ovman.agents.reference.reasoning import two_visits
from ovman.language import noun
from ovman.perception.detected import Detected
from ovman.perception.object_map import ObjectMap


def predict_current(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arm of one memory of both tours. Reads dynamem.*."""
    both = _tours(context, VISITS).remembered()
    return located(*both, context.noun(noun(query.category)), context.settings.dynamem), None


def predict_two_visits(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arm of a memory of each tour: the reference agent's rules on the objects that the noun means in them.

    Reads dynamem.*, grounding.similarity_margin, association.* and admissibility.tau_m. An object has one place, so the answer to
    MOVING is the place of the new object that was seen last.
    """
    phrase, settings = context.noun(noun(query.category)), context.settings
    memories = [_tours(context, [which]).remembered()[0] for which in VISITS]
    map_1, map_2 = (meant(one, phrase, settings.grounding.similarity_margin, settings.dynamem) for one in memories)
    outcome, _ = two_visits(query.relation, map_1, map_2, range(len(map_1)), range(len(map_2)), settings)
    return outcome, None


@dataclass(frozen=True)
class Tours:
    """The tours that a memory is of, by what they show, with the constants of the memory."""

    contents: tuple[str | None, ...]
    values: tuple[tuple[str, float], ...]
    seen: tuple[tuple[Visit, Detected], ...] = field(compare=False, repr=False)
    constants: Dynamem = field(compare=False, repr=False)

    @staticmethod
    def of(seen: Iterable[tuple[Visit, Detected]], constants: Dynamem) -> Tours:
        """Tours with what was detected in them, in their order."""
        every = tuple(seen)
        return Tours(tuple(visit.content for visit, _ in every), tuple(constants), every, constants)

    def remembered(self) -> tuple[Memory, tuple[Look, ...]]:
        """One memory of the frames of all tours, and the frames. Recorded tours are remembered once, under whatever seeds a run
        asks again, and whatever tour follows them."""
        if not self.seen:
            return Memory.empty(), ()
        return _remember(self) if None in self.contents else _remember_once(self)


def _remember(tours: Tours) -> tuple[Memory, tuple[Look, ...]]:
    *before, (visit, detected) = tours.seen
    memory, frames = Tours.of(before, tours.constants).remembered()
    new = looks(visit, detected, tours.constants)
    return remembered(new, tours.constants, memory, len(frames)), (*frames, *new)


# A memory is large. The seeds of an episode follow each other, and so do the episodes with one first tour.
_remember_once = lru_cache(maxsize=2)(_remember)


def located(memory: Memory, frames: Sequence[Look], phrase: np.ndarray, constants: Dynamem) -> Answer | Abstention:
    """Where the memory of `frames` has what a noun (K,) means.

    The most similar voxel, the first in a tie, names the frame that saw it last. The place of the most similar detection of that
    frame is the answer, of those that are similar enough and near enough; without one the place of the voxel, if that is similar
    enough. Else, and with an empty memory, it abstains with NOTHING_GROUNDED.
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


def meant(memory: Memory, phrase: np.ndarray, similarity_margin: float, constants: Dynamem) -> ObjectMap:
    """The objects of a memory that a noun (K,) means: groups of neighbouring voxels that are nearly as similar as the best one.

    Place and feature of an object are the means of its voxels', and it was last seen when the latest of them was.
    """
    if not len(memory):
        return ObjectMap.of(())
    features = _unit(memory.feature)
    chosen = np.array(grounded(features, phrase, similarity_margin), np.int64)
    groups = _groups(memory.point[chosen], constants.cluster_voxels * constants.voxel_m)
    members = [chosen[groups == group] for group in range(groups.max() + 1)]
    places = np.array([memory.point[mine][:, [0, 2]].mean(axis=0) for mine in members])
    return ObjectMap(
        p=places,
        f=_unit(np.array([features[mine].mean(axis=0) for mine in members])),
        tracks=tuple(places[:, None]),
        last_seen=tuple(int(memory.seen[mine].max()) for mine in members),
    )


def _groups(points: np.ndarray, radius_m: float) -> np.ndarray:
    """(N,) numbers of the groups that points (N, 3) form where neighbours within a radius belong together."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    near = cKDTree(points).query_pairs(radius_m, output_type="ndarray")
    links = coo_matrix((np.ones(len(near), bool), (near[:, 0], near[:, 1])), shape=(len(points), len(points)))
    groups: np.ndarray = connected_components(links, directed=False)[1]
    return groups


def _tours(context: PredictionContext, visits: Iterable[str]) -> Tours:
    return Tours.of([(context.tour(which), context.detections(which)) for which in visits], context.settings.dynamem)


def _unit(features: np.ndarray) -> np.ndarray:
    unit: np.ndarray = features / np.maximum(np.linalg.norm(features, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    return unit


def _answer(point: np.ndarray) -> Answer:
    return Answer(float(point[0]), float(point[2]))
