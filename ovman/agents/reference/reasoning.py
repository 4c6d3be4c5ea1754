"""From maps of two visits and a noun to an answer: grounding and the decision rules of the reference agent (Eq. rules).

Functions that take `settings` read association.*, admissibility.tau_m and, to ground a noun, grounding.similarity_margin.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ovman.agents.interface import (
    VISITS,
    Abstention,
    AbstentionReason,
    Answer,
    Evidence,
    PredictionContext,
    Query,
    Relation,
    UniformBox,
    UniformPick,
)
from ovman.agents.reference.association import Association, associate, distances, positions
from ovman.perception.clusters import ObjectMap
from ovman.settings import Settings

# Grounding: which objects of a map a noun means ------------------------------------------------------------------------------


def similarities(features: ArrayLike, noun: ArrayLike) -> np.ndarray:
    """Return s (N,): inner products of unit features (N, K) with the unit text embedding (K,) of a noun phrase.

    An instance's similarity does not depend on what else is in the map.
    """
    f, q = np.asarray(features, dtype=np.float64), np.asarray(noun, dtype=np.float64)
    if not f.size:
        return np.zeros(0)
    # Not a matrix product, whose last bit depends on the row's place in the matrix.
    similarity: np.ndarray = (f * q).sum(axis=1)
    return similarity


def ground(features: ArrayLike, noun: ArrayLike, similarity_margin: float) -> tuple[int, ...]:
    """Return G_v: the sorted indices i of a map with s_i >= max_j s_j - similarity_margin; none for an empty map.

    A near-tie does not discard the right instance. features, noun: as for `similarities`; similarity_margin: delta_g. Source: the
    paper's grounding stage.
    """
    s = similarities(features, noun)
    return tuple(np.flatnonzero(s >= s.max() - similarity_margin).tolist()) if len(s) else ()


def ground_query(query: Query, context: PredictionContext, objects: ObjectMap, *visits: str) -> tuple[int, ...]:
    """Return the objects of a map of `visits` that the query's noun means: the true ones if the arm is given its grounding.

    Without a noun (input ablation) these are all objects.
    """
    if not query.phrase:
        return tuple(range(len(objects)))
    if context.privileged_grounding:
        return context.true_objects(objects, *visits)
    return ground(objects.f, context.noun(query.phrase), context.settings.grounding.similarity_margin)


# Two visits -------------------------------------------------------------------------------------------------------------------


def answer_query(
    query: Query, context: PredictionContext, map_1: ObjectMap, map_2: ObjectMap
) -> tuple[Answer | Abstention, Evidence]:
    """Answer a query from maps of both visits, as `answer_two_visits`, grounded by `ground_query`."""
    first, second = VISITS
    grounded_1, grounded_2 = ground_query(query, context, map_1, first), ground_query(query, context, map_2, second)
    return answer_two_visits(query.relation, map_1, map_2, grounded_1, grounded_2, context.settings)


def answer_phrase(
    relation: Relation, map_1: ObjectMap, map_2: ObjectMap, phrase: np.ndarray, settings: Settings
) -> tuple[Answer | Abstention, Evidence]:
    """Answer as `answer_two_visits`, grounded by the unit embedding (K,) of a noun phrase."""
    margin = settings.grounding.similarity_margin
    grounded_1, grounded_2 = ground(map_1.f, phrase, margin), ground(map_2.f, phrase, margin)
    return answer_two_visits(relation, map_1, map_2, grounded_1, grounded_2, settings)


def answer_two_visits(
    relation: Relation,
    map_1: ObjectMap,
    map_2: ObjectMap,
    grounded_1: Sequence[int],
    grounded_2: Sequence[int],
    settings: Settings,
    disagreement: np.ndarray | None = None,
) -> tuple[Answer | Abstention, Evidence]:
    """Answer as the two-visit agent from its maps of both visits, and return the evidence (Eq. cost, Eq. pad, Eq. rules).

    Abstains with NOTHING_GROUNDED if the noun means nothing in either map, else as `decide` and, for MOVING,
    `decide_by_last_sighting` do. The order of a map's objects does not matter.

    grounded_1, grounded_2: indices of the objects that the noun means; disagreement: (len(map_1), len(map_2)) as in `associate`,
    by the objects' features if None.
    """
    g_1, g_2 = list(grounded_1), list(grounded_2)
    constants = settings.association
    matched = associate(
        map_1.p[g_1],
        map_2.p[g_2],
        map_1.f[g_1],
        map_2.f[g_2],
        gate_m=constants.gate_m,
        feature_scale_m=constants.feature_scale_m,
        disagreement=None if disagreement is None else disagreement[np.ix_(g_1, g_2)],
    )
    evidence = Evidence(tuple(g_1), tuple(g_2), tuple((g_1[i], g_2[j]) for i, j in matched.pairs))
    if not g_1 and not g_2:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), evidence
    if Relation(relation) is Relation.MOVING:
        tracks, last_seen = [map_2.tracks[j] for j in g_2], [map_2.last_seen[j] for j in g_2]
        return decide_by_last_sighting(tracks, last_seen, matched), evidence
    return decide(relation, map_1.p[g_1], map_2.p[g_2], matched, settings.admissibility.tau_m), evidence


def decide(relation: Relation, p_1: ArrayLike, p_2: ArrayLike, association: Association, tau_m: float) -> Answer | Abstention:
    """Answer a relation but MOVING, given the association of the visits (Eq. rules of the paper and the fallbacks below it).

    Equal candidates are told apart by position (smallest x, then z): the answer does not depend on the order of the instances. If
    the other visit shows nothing, a single candidate is the answer; several cannot be ranked, and the agent abstains with
    NO_COUNTERPART.

    Args:
        relation: The change relation.
        p_1: (N, 2) floor-plane positions (x, z) in metres of the grounded instances of visit 1.
        p_2: (M, 2) positions of the grounded instances of visit 2.
        association: Of the indices into p_1 and p_2.
        tau_m: Displacement in metres from which an instance has moved.
    """
    relation, p_1, p_2 = Relation(relation), positions(p_1, "p_1"), positions(p_2, "p_2")
    if relation is Relation.STABLE:
        return _steadiest(p_1, p_2, association, tau_m)
    alone = _farthest(p_1, association.unmatched_1, p_2) if relation.past else _farthest(p_2, association.unmatched_2, p_1)
    if relation in (Relation.APPEARED, Relation.REMOVED):
        return alone or Abstention(AbstentionReason.NO_CANDIDATE)
    return alone or _most_displaced(p_1, p_2, association, 0 if relation.past else 1, tau_m)


def decide_by_spread(tracks_2: Sequence[ArrayLike], track_spread_m: float) -> Answer | Abstention:
    """Answer MOVING with true positions: the last point of the track of largest spread, provided it exceeds track_spread_m.

    Abstains with NO_CANDIDATE if nothing was seen at all, NO_MOTION if no track spread far enough. tracks_2: for each instance of
    visit 2 its floor-plane positions (T, 2) in metres in the order they were seen; track_spread_m: tau_trk.
    """
    tracks = [track for track in (positions(track, "track") for track in tracks_2) if len(track)]
    if not tracks:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    spread, track = min(((spread_m(track), track) for track in tracks), key=lambda item: (-item[0], *item[1][-1]))
    if not spread > track_spread_m:
        return Abstention(AbstentionReason.NO_MOTION)
    return _answer(track[-1])


def decide_by_last_sighting(
    tracks_2: Sequence[ArrayLike], last_seen: Sequence[int], association: Association
) -> Answer | Abstention:
    """Answer MOVING under real perception: the last track point of the unmatched cluster of visit 2 that was seen latest.

    A moving object fragments into several clusters, none of which was there in visit 1. Abstains with NO_CANDIDATE if every
    cluster is matched. tracks_2: as for `decide_by_spread`, T >= 1; last_seen: index of the view each cluster was last seen in.
    """
    candidates = [(last_seen[j], positions(tracks_2[j], "track")[-1]) for j in association.unmatched_2]
    if not candidates:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    _, point = min(candidates, key=lambda item: (-item[0], *item[1]))
    return _answer(point)


def spread_m(track: ArrayLike) -> float:
    """Return the largest distance in metres between two points of a track (T, 2); 0 for fewer than two points."""
    track = positions(track, "track")
    return float(distances(track, track).max()) if len(track) else 0.0


def _farthest(points: np.ndarray, unmatched: Sequence[int], others: np.ndarray) -> Answer | Abstention | None:
    """Answer with the unmatched point farthest from its nearest counterpart in the other visit; None if nothing is unmatched.

    Without a counterpart in the other visit the distance is undefined: one point needs none, several cannot be ranked.
    """
    if not unmatched:
        return None
    if not len(others) and len(unmatched) > 1:
        return Abstention(AbstentionReason.NO_COUNTERPART)
    nearest = distances(points, others).min(axis=1, initial=np.inf)
    return _answer(points[min(unmatched, key=lambda i: (-nearest[i], *points[i]))])


def _most_displaced(p_1: np.ndarray, p_2: np.ndarray, association: Association, end: int, tau_m: float) -> Answer | Abstention:
    """Answer with the end (0: visit 1, 1: visit 2) of the pair of largest displacement, provided that reaches tau_m."""
    if not association.pairs:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    apart = distances(p_1, p_2)
    i, j = min(association.pairs, key=lambda pair: (-apart[pair], *p_1[pair[0]], *p_2[pair[1]]))
    return _answer((p_1[i], p_2[j])[end]) if apart[i, j] >= tau_m else Abstention(AbstentionReason.DISPLACEMENT_BELOW_TAU)


def _steadiest(p_1: np.ndarray, p_2: np.ndarray, association: Association, tau_m: float) -> Answer | Abstention:
    """Answer with the visit-2 end of the pair of smallest displacement, provided that is below tau_m."""
    if not association.pairs:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    apart = distances(p_1, p_2)
    i, j = min(association.pairs, key=lambda pair: (apart[pair], *p_2[pair[1]], *p_1[pair[0]]))
    return _answer(p_2[j]) if apart[i, j] < tau_m else Abstention(AbstentionReason.DISPLACEMENT_ABOVE_TAU)


def _answer(point: np.ndarray) -> Answer:
    return Answer(float(point[0]), float(point[1]))


# One visit --------------------------------------------------------------------------------------------------------------------


def pick_grounded(
    relation: Relation, map_2: ObjectMap, grounded_2: Sequence[int], reachable: ArrayLike
) -> tuple[UniformPick | UniformBox | Abstention, Evidence]:
    """Return the single-visit agent's pick given its map of the second visit, and the evidence.

    A current relation is answered with the place of a grounded object, MOVING with its last track point; a past one, for which
    the visit holds no evidence, with a position in the bounding box of `reachable` (K, 2). Abstains with NOTHING_GROUNDED if a
    current relation has no grounded object. Source: the single-visit baseline of the paper's problem formulation.
    """
    relation, evidence = Relation(relation), Evidence(None, tuple(grounded_2))
    if not relation.past and not evidence.grounded_2:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), evidence
    places = [map_2.tracks[j] if relation is Relation.MOVING else map_2.p[[j]] for j in evidence.grounded_2]
    return pick_instance(relation, places, reachable), evidence


def pick_instance(relation: Relation, tracks_2: Sequence[ArrayLike], reachable: ArrayLike) -> UniformPick | UniformBox:
    """Return a uniform pick among the last track points, or for a past relation the bounding box of `reachable` (K, 2), K >= 1.

    tracks_2: as for `decide_by_spread`; one row for an instance that stands still.
    """
    if Relation(relation).past:
        points = positions(reachable, "reachable")
        (x_min, z_min), (x_max, z_max) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        return UniformBox(x_min, z_min, x_max, z_max)
    tracks = (positions(track, "track") for track in tracks_2)
    return UniformPick(tuple(sorted((float(track[-1, 0]), float(track[-1, 1])) for track in tracks if len(track))))
