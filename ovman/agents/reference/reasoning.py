"""From maps of two visits and what a noun means in them to an answer: the reference agent without perception and navigation.

Functions that take `settings` read association.*, admissibility.tau_m and, where they ground a noun, grounding.similarity_margin.
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
from ovman.agents.reference.association import Association, associate, positions
from ovman.agents.reference.decision import decide, moving_by_last_sighting
from ovman.agents.reference.grounding import grounded
from ovman.language import noun
from ovman.perception.object_map import ObjectMap
from ovman.settings import Settings
from ovman.settings import benchmark as sections


def two_visits(
    relation: Relation,
    map_1: ObjectMap,
    map_2: ObjectMap,
    grounded_1: Sequence[int],
    grounded_2: Sequence[int],
    settings: Settings,
    disagreement: np.ndarray | None = None,
) -> tuple[Answer | Abstention, Evidence]:
    """What the two-visit agent answers from its maps of both visits, and from which evidence.

    grounded_1, grounded_2: indices of what the noun means in each map. disagreement: as in ``associate``, of all objects of the
    maps, (len(map_1), len(map_2)); by their features if not given. Abstains with NOTHING_GROUNDED where that is nothing in
    either, else as ``decide`` and, for MOVING, ``moving_by_last_sighting`` do. The order of a map's objects is of no
    consequence. Source: Eq. cost, Eq. pad, Eq. rules.
    """
    g_1, g_2 = list(grounded_1), list(grounded_2)
    p_1, p_2 = map_1.p[g_1], map_2.p[g_2]
    matched = _associated(map_1, map_2, g_1, g_2, settings.association, disagreement)
    evidence = Evidence(tuple(g_1), tuple(g_2), tuple((g_1[i], g_2[j]) for i, j in matched.pairs))
    if not g_1 and not g_2:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), evidence
    if Relation(relation) is Relation.MOVING:
        tracks, last_seen = [map_2.tracks[j] for j in g_2], [map_2.last_seen[j] for j in g_2]
        return moving_by_last_sighting(tracks, last_seen, matched), evidence
    answer = decide(
        relation,
        p_1,
        p_2,
        matched,
        (),
        tau_m=settings.admissibility.tau_m,
        track_spread_m=settings.association.track_spread_m,
    )
    return answer, evidence


def two_visits_asked(
    relation: Relation, map_1: ObjectMap, map_2: ObjectMap, phrase: np.ndarray, settings: Settings
) -> tuple[Answer | Abstention, Evidence]:
    """``two_visits``, with what the noun phrase of this unit embedding (K,) means by the features of the maps."""
    means_1, means_2 = (grounded(made.f, phrase, settings.grounding.similarity_margin) for made in (map_1, map_2))
    return two_visits(relation, map_1, map_2, means_1, means_2, settings)


def two_visits_recorded(
    query: Query, context: PredictionContext, map_1: ObjectMap, map_2: ObjectMap
) -> tuple[Answer | Abstention, Evidence]:
    """``two_visits`` on maps of both visits, with what the query's noun means in them (``means_of``)."""
    means_1, means_2 = (means_of(query, context, made, which) for which, made in zip(VISITS, (map_1, map_2), strict=True))
    return two_visits(query.relation, map_1, map_2, means_1, means_2, context.settings)


def means_of(query: Query, context: PredictionContext, objects: ObjectMap, *visits: str) -> tuple[int, ...]:
    """Which objects of a map that was made of `visits` the query's noun means: by their features, or the true ones if given.

    All of them where the noun is withheld.
    """
    if not query.category:
        return tuple(range(len(objects)))
    if context.privileged_grounding:
        return context.true_objects(objects, *visits)
    return grounded(objects.f, context.noun(noun(query.category)), context.settings.grounding.similarity_margin)


def one_visit(
    relation: Relation, map_2: ObjectMap, grounded_2: Sequence[int], reachable: ArrayLike
) -> tuple[UniformPick | UniformBox | Abstention, Evidence]:
    """What the single-visit agent picks from, given its map of the second visit, and from which evidence.

    grounded_2: indices of what the noun means in the map; reachable (K, 2): positions in metres that the agent can reach.
    Current relations are answered with the place of a grounded object, MOVING with its last track point; past ones, for which
    the visit holds no evidence, with a position in the bounding box of what is reachable. Abstains with NOTHING_GROUNDED where
    a current relation finds nothing grounded. Raises ValueError as ``single_visit_pick`` does.
    Source: the single-visit baseline of the paper's problem formulation.
    """
    relation, evidence = Relation(relation), Evidence(None, tuple(grounded_2))
    if not relation.past and not evidence.grounded_2:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), evidence
    places = [map_2.tracks[j] if relation is Relation.MOVING else map_2.p[[j]] for j in evidence.grounded_2]
    return single_visit_pick(relation, places, reachable), evidence


def single_visit_pick(relation: Relation, tracks_2: Sequence[ArrayLike], reachable: ArrayLike) -> UniformPick | UniformBox:
    """What the single-visit agent picks from.

    tracks_2: for each grounded instance of visit 2 its floor-plane positions (T, 2) in metres in the order they were seen (one
    row for an instance that stands still); reachable (K, 2), K >= 1: positions that the agent can reach. Current relations are
    answered with an instance of visit 2 at its last track point, past ones, for which the visit holds no evidence, with a
    position in the bounding box of what is reachable.

    Raises ValueError where a past relation is asked and nothing is reachable.
    """
    if Relation(relation).past:
        points = positions(reachable, "reachable")
        if not len(points):
            raise ValueError("the reachable positions are empty: a past relation has no box to answer from")
        (x_min, z_min), (x_max, z_max) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        return UniformBox(x_min, z_min, x_max, z_max)
    tracks = (positions(track, "track") for track in tracks_2)
    return UniformPick(tuple(sorted((float(track[-1, 0]), float(track[-1, 1])) for track in tracks if len(track))))


def _associated(
    map_1: ObjectMap,
    map_2: ObjectMap,
    g_1: list[int],
    g_2: list[int],
    constants: sections.Association,
    disagreement: np.ndarray | None,
) -> Association:
    return associate(
        map_1.p[g_1],
        map_2.p[g_2],
        map_1.f[g_1],
        map_2.f[g_2],
        gate_m=constants.gate_m,
        feature_scale_m=constants.feature_scale_m,
        disagreement=None if disagreement is None else disagreement[np.ix_(g_1, g_2)],
    )
