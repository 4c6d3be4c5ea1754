"""What the two-visit reference agent answers, given the association of the two visits (Eq. rules of the paper)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ovman.agents.interface import Abstention, AbstentionReason, Answer, Relation
from ovman.agents.reference.association import Association, distances, positions


def decide(
    relation: Relation,
    p_1: ArrayLike,
    p_2: ArrayLike,
    association: Association,
    tracks_2: Sequence[ArrayLike],
    *,
    tau_m: float,
    track_spread_m: float,
) -> Answer | Abstention:
    """The answer of the two-visit agent for one relation (Eq. rules of the paper).

    p_1 (N, 2), p_2 (M, 2): floor-plane positions (x, z) in metres of the grounded instances of the two visits; association: of
    their indices; tracks_2: for each instance of visit 2 its positions (T, 2) in the order they were seen, read for MOVING
    only, by the rule for the arms that are given positions (``moving_by_spread``). An agent with perception of its own answers
    MOVING with ``moving_by_last_sighting``. tau_m: displacement in metres from which an instance has moved; track_spread_m:
    tau_trk, spread of a track in metres that counts as motion.

    Equal candidates are told apart by position (smallest x, then z): the answer does not depend on the order of the instances.
    Where the other visit shows nothing, the one candidate is answered; of several none is farther from its counterpart than the
    others, and the agent abstains with NO_COUNTERPART.
    Source: Eq. rules and the fallbacks stated below it.
    """
    p_1, p_2 = positions(p_1, "p_1"), positions(p_2, "p_2")
    match Relation(relation):
        case Relation.MOVING:
            return moving_by_spread(tracks_2, track_spread_m)
        case Relation.STABLE:
            return _steadiest(p_1, p_2, association, tau_m)
        case Relation.APPEARED:
            return _farthest(p_2, association.unmatched_2, p_1) or Abstention(AbstentionReason.NO_CANDIDATE)
        case Relation.REMOVED:
            return _farthest(p_1, association.unmatched_1, p_2) or Abstention(AbstentionReason.NO_CANDIDATE)
        case Relation.MOVED:
            return _farthest(p_2, association.unmatched_2, p_1) or _most_displaced(p_1, p_2, association, 1, tau_m)
        case Relation.FORMER:
            return _farthest(p_1, association.unmatched_1, p_2) or _most_displaced(p_1, p_2, association, 0, tau_m)


def moving_by_spread(tracks_2: Sequence[ArrayLike], track_spread_m: float) -> Answer | Abstention:
    """MOVING with ground-truth positions: the last point of the track of largest spread, provided it exceeds track_spread_m.

    tracks_2: for each instance of visit 2 its floor-plane positions (T, 2) in metres in the order they were seen; the spread of
    a track is the largest distance between two of its points. Abstains with NO_CANDIDATE where nothing was seen at all,
    NO_MOTION where nothing spread far enough. Source: the paper's rule for MOVING, ground-truth positions.
    """
    tracks = [track for track in (positions(track, "track") for track in tracks_2) if len(track)]
    if not tracks:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    spread, track = min(((spread_m(track), track) for track in tracks), key=lambda item: (-item[0], *item[1][-1]))
    if not spread > track_spread_m:
        return Abstention(AbstentionReason.NO_MOTION)
    return _answer(track[-1])


def moving_by_last_sighting(
    tracks_2: Sequence[ArrayLike], last_seen: Sequence[int], association: Association
) -> Answer | Abstention:
    """MOVING under real perception: the last track point of the unmatched cluster of visit 2 that was seen latest.

    tracks_2: for each cluster of visit 2 its floor-plane positions (T, 2), T >= 1, in metres in the order they were seen;
    last_seen: for each cluster the index of the view it was last seen in. A moving object fragments into several clusters, none
    of which was there in visit 1. Abstains with NO_CANDIDATE where every cluster is matched. Source: the paper's rule for
    MOVING, real perception.
    """
    candidates = [(last_seen[j], positions(tracks_2[j], "track")[-1]) for j in association.unmatched_2]
    if not candidates:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    _, point = min(candidates, key=lambda item: (-item[0], *item[1]))
    return _answer(point)


def spread_m(track: ArrayLike) -> float:
    """Largest distance in metres between two points of a track (T, 2); 0 for fewer than two points."""
    track = positions(track, "track")
    return float(distances(track, track).max()) if len(track) else 0.0


def _farthest(points: np.ndarray, unmatched: Sequence[int], others: np.ndarray) -> Answer | Abstention | None:
    """The unmatched point farthest from its nearest counterpart in the other visit; None where nothing is unmatched.

    Without a counterpart in the other visit the distance has no argument: one point needs none, several cannot be ranked.
    """
    if not unmatched:
        return None
    if not len(others) and len(unmatched) > 1:
        return Abstention(AbstentionReason.NO_COUNTERPART)
    nearest = distances(points, others).min(axis=1, initial=np.inf)
    return _answer(points[min(unmatched, key=lambda i: (-nearest[i], *points[i]))])


def _most_displaced(p_1: np.ndarray, p_2: np.ndarray, association: Association, end: int, tau_m: float) -> Answer | Abstention:
    """The end (0: visit 1, 1: visit 2) of the matched pair of largest displacement, provided that reaches tau_m."""
    if not association.pairs:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    displacement, i, j = min(_displacements(p_1, p_2, association), key=lambda item: (-item[0], *p_1[item[1]], *p_2[item[2]]))
    if displacement < tau_m:
        return Abstention(AbstentionReason.DISPLACEMENT_BELOW_TAU)
    return _answer(p_2[j] if end else p_1[i])


def _steadiest(p_1: np.ndarray, p_2: np.ndarray, association: Association, tau_m: float) -> Answer | Abstention:
    """The visit-2 end of the matched pair of smallest displacement, provided that is below tau_m."""
    if not association.pairs:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    displacement, _, j = min(_displacements(p_1, p_2, association), key=lambda item: (item[0], *p_2[item[2]], *p_1[item[1]]))
    if not displacement < tau_m:
        return Abstention(AbstentionReason.DISPLACEMENT_ABOVE_TAU)
    return _answer(p_2[j])


def _displacements(p_1: np.ndarray, p_2: np.ndarray, association: Association) -> list[tuple[float, int, int]]:
    distance = distances(p_1, p_2)
    return [(float(distance[i, j]), i, j) for i, j in association.pairs]


def _answer(point: np.ndarray) -> Answer:
    return Answer(float(point[0]), float(point[1]))
