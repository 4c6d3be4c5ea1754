"""The arms on REACT: instances that look alike are clustered, and matched between the visits by the distance that they travelled.

REACT's output says which instances were matched, are absent and are new, and knows no noun. It is read by relation among the
instances that the noun means to the reference agent in either visit; a matched pair is meant if one of its ends is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.interface import VISITS, Abstention, AbstentionReason, Answer, Evidence, PredictionContext, Query, Relation
from ovman.agents.reference.agents import TwoVisits
from ovman.agents.reference.association import Association, distances
from ovman.agents.reference.reasoning import decide, decide_by_last_sighting, ground, ground_query, similarities
from ovman.agents.words import understands
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS
from ovman.perception.clusters import ObjectMap
from ovman.settings import Settings

# Arms -------------------------------------------------------------------------------------------------------------------------


@understands
def predict_two_visits(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, Evidence]:
    """Answer as the static arm. Reads react.*, grounding.similarity_margin and admissibility.tau_m."""
    first, second = VISITS
    map_1, map_2 = context.map(first), context.map(second)
    meant_1, meant_2 = ground_query(query, context, map_1, first), ground_query(query, context, map_2, second)
    return answer(query.relation, map_1, map_2, meant_1, meant_2, embedding=context.noun, settings=context.settings)


class ReactAgent(TwoVisits):
    """The arm react_two_visits_embodied."""

    def decide(self, query: Query) -> Answer | Abstention:
        """Answer from both maps."""
        settings, phrase = self.context.settings, self.context.noun(query.phrase)
        margin = settings.grounding.similarity_margin
        meant_1, meant_2 = ground(self.map_1.f, phrase, margin), ground(self.map_2.f, phrase, margin)
        maps = self.map_1, self.map_2
        return answer(query.relation, *maps, meant_1, meant_2, embedding=self.context.noun, settings=settings)[0]


def answer(
    relation: Relation,
    map_1: ObjectMap,
    map_2: ObjectMap,
    meant_1: Sequence[int],
    meant_2: Sequence[int],
    *,
    embedding: Callable[[str], np.ndarray],
    settings: Settings,
) -> tuple[Answer | Abstention, Evidence]:
    """Answer from the maps of two visits, and return the evidence.

    Abstains with NOTHING_GROUNDED if the noun means nothing in either visit, and as `decide_relation` does. meant_1, meant_2:
    indices of the objects that the noun means; embedding: returns the unit embedding (K,) of the name of a class.
    """
    if not meant_1 and not meant_2:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), Evidence((), ())
    classes = np.stack([embedding(noun(category)) for category in SYNONYMS])
    output = match_instances(map_1, map_2, classes, settings.react.appearance)
    found = Association(
        pairs=tuple((i, j) for i, j in output.pairs if i in meant_1 or j in meant_2),
        unmatched_1=tuple(i for i in output.unmatched_1 if i in meant_1),
        unmatched_2=tuple(j for j in output.unmatched_2 if j in meant_2),
    )
    of_1, of_2 = _members(found)
    return decide_relation(relation, map_1, map_2, found, settings), Evidence(tuple(of_1), tuple(of_2), found.pairs)


def decide_relation(
    relation: Relation, map_1: ObjectMap, map_2: ObjectMap, found: Association, settings: Settings
) -> Answer | Abstention:
    """Answer a relation from the objects `found`, which the noun means.

    A matched instance has moved if it travelled tau_m or more. MOVED and FORMER: the matched one that moved farthest; without
    one a new, or an absent one, whose match was missed. APPEARED: a new one. REMOVED: an absent one. STABLE: the matched one
    that moved least, if it has not moved. MOVING: of the new and the moved ones the one that was seen last. Of several new or
    absent ones the one farthest from the other visit's. Abstains as the reference agent's rules do.
    """
    if Relation(relation) is Relation.MOVING:
        apart = distances(map_1.p, map_2.p)
        moved = {j for i, j in found.pairs if apart[i, j] >= settings.admissibility.tau_m}
        on_the_move = Association((), (), tuple(sorted({*found.unmatched_2} | moved)))
        return decide_by_last_sighting(map_2.tracks, map_2.last_seen, on_the_move)
    if Relation(relation) in (Relation.MOVED, Relation.FORMER):
        outcome = _decide_among(relation, map_1, map_2, Association(found.pairs, (), ()), settings)
        if isinstance(outcome, Answer) or not (found.unmatched_2 if relation is Relation.MOVED else found.unmatched_1):
            return outcome
    return _decide_among(relation, map_1, map_2, found, settings)


def _decide_among(
    relation: Relation, map_1: ObjectMap, map_2: ObjectMap, found: Association, settings: Settings
) -> Answer | Abstention:
    """Answer by the reference agent's rules on the objects of `found` alone."""
    of_1, of_2 = _members(found)
    number_1, number_2 = ({index: n for n, index in enumerate(of)} for of in (of_1, of_2))
    renumbered = Association(
        pairs=tuple((number_1[i], number_2[j]) for i, j in found.pairs),
        unmatched_1=tuple(number_1[i] for i in found.unmatched_1),
        unmatched_2=tuple(number_2[j] for j in found.unmatched_2),
    )
    return decide(relation, map_1.p[of_1], map_2.p[of_2], renumbered, settings.admissibility.tau_m)


def _members(found: Association) -> tuple[list[int], list[int]]:
    """Return the sorted indices of both visits' objects in an association."""
    of_1 = sorted({*found.unmatched_1, *(i for i, _ in found.pairs)})
    of_2 = sorted({*found.unmatched_2, *(j for _, j in found.pairs)})
    return of_1, of_2


# Instances, clusters and matches ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Instances of both visits that look alike, by their numbers in their visits. feature (K,): mean over all views."""

    kind: int
    feature: np.ndarray
    views: int
    first: tuple[int, ...] = ()
    second: tuple[int, ...] = ()

    def merge(self, other: Cluster) -> Cluster:
        """Return both as one cluster."""
        views = self.views + other.views
        feature = (self.feature * self.views + other.feature * other.views) / views
        first, second = sorted(self.first + other.first), sorted(self.second + other.second)
        return Cluster(self.kind, feature, views, tuple(first), tuple(second))


def match_instances(first: ObjectMap, second: ObjectMap, classes: np.ndarray, appearance: float) -> Association:
    """Return matched instances, absent ones (unmatched_1) and new ones (unmatched_2). classes: their unit embeddings (C, K).

    In a cluster as many instances are matched as there are in the visit with fewer, so that the sum of travelled distances is
    least.
    """
    pairs: list[tuple[int, int]] = []
    for cluster in cluster_instances(first, second, classes, appearance):
        old, new = _order_by_place(first, cluster.first), _order_by_place(second, cluster.second)
        if len(old) and len(new):
            from scipy.optimize import linear_sum_assignment  # takes half a second, and most jobs need none

            rows, columns = linear_sum_assignment(distances(first.p[old], second.p[new]))
            pairs += zip(old[rows].tolist(), new[columns].tolist(), strict=True)
    known, seen_again = {i for i, _ in pairs}, {j for _, j in pairs}
    return Association(
        pairs=tuple(sorted(pairs)),
        unmatched_1=tuple(i for i in range(len(first)) if i not in known),
        unmatched_2=tuple(j for j in range(len(second)) if j not in seen_again),
    )


def _order_by_place(objects: ObjectMap, of: tuple[int, ...]) -> np.ndarray:
    """Order instances by place: among equal optima the assignment then does not depend on their numbers."""
    numbers = np.array(of, np.int64)
    ordered: np.ndarray = numbers[np.lexsort(objects.p[numbers].T[::-1])]
    return ordered


def cluster_instances(first: ObjectMap, second: ObjectMap, classes: np.ndarray, appearance: float) -> tuple[Cluster, ...]:
    """Cluster the first visit's instances; the second visit's then join these clusters or form their own.

    The class of an instance is the most similar one, the first in a tie.
    """
    old, new = (
        [
            Cluster(int(similarities(classes, feature).argmax()), feature, len(track), **{which: (number,)})
            for number, (feature, track) in enumerate(zip(objects.f, objects.tracks, strict=True))
        ]
        for which, objects in zip(VISITS, (first, second), strict=True)
    )
    return merge_clusters([*merge_clusters(old, appearance), *new], appearance)


def merge_clusters(found: Sequence[Cluster], appearance: float) -> tuple[Cluster, ...]:
    """Merge clusters of one class whose features are at most `appearance` apart until there are none left.

    The nearest pair is merged first, so that the order of the clusters does not matter.
    """
    left = sorted(found, key=lambda cluster: (cluster.kind, *cluster.feature.tolist(), cluster.views))
    while True:
        pair = _nearest(left)
        if pair is None or pair[0] > appearance:
            return tuple(left)
        _, a, b = pair
        left = [one for k, one in enumerate(left) if k not in (a, b)] + [left[a].merge(left[b])]


def _nearest(found: Sequence[Cluster]) -> tuple[float, int, int] | None:
    """Return distance and indices of the two clusters of one class that are nearest to each other, the first in a tie."""
    if len(found) < 2:
        return None
    features, kinds = np.array([one.feature for one in found]), np.array([one.kind for one in found])
    apart = np.linalg.norm(features[:, None] - features[None], axis=2)
    apart[kinds[:, None] != kinds[None]] = np.inf
    apart[np.tril_indices(len(found))] = np.inf
    a, b = np.unravel_index(int(apart.argmin()), apart.shape)
    return (float(apart[a, b]), int(a), int(b)) if np.isfinite(apart[a, b]) else None
