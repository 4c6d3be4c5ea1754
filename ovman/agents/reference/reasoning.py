"""From maps of two visits and what a noun means in them to an answer: the reference agent without its eyes and wheels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ovman.agents.interface import VISITS
from ovman.agents.reference.association import Association, associate
from ovman.agents.reference.decision import (
    Abstention,
    AbstentionReason,
    Answer,
    DecisionConstants,
    decide,
    moving_by_last_sighting,
)
from ovman.agents.reference.grounding import grounded
from ovman.agents.reference.object_map import ObjectMap
from ovman.agents.reference.privileged_positions import AssociationConstants
from ovman.agents.reference.single_visit import UniformBox, UniformPick, single_visit
from ovman.language import noun
from ovman.models.settings import Settings, Source
from ovman.task import Query, Relation

if TYPE_CHECKING:
    from ovman.evaluation.context import Recorded


@dataclass(frozen=True, slots=True)
class ReferenceConstants:
    """similarity_margin: delta_g of the grounding; association: gamma and lambda; decision: tau."""

    similarity_margin: float
    association: AssociationConstants
    decision: DecisionConstants

    @staticmethod
    def of(constants: Settings) -> ReferenceConstants:
        """Those of config.yaml; `constants` must own grounding.*, association.* and admissibility.tau_m."""
        return ReferenceConstants(
            constants.grounding.similarity_margin, AssociationConstants.of(constants), DecisionConstants.of(constants)
        )


@dataclass(frozen=True, slots=True)
class Evidence:
    """What an answer was drawn from. Indices are those of the visits' maps.

    grounded_1, grounded_2: what the noun means in each visit, grounded_1 None where the first visit is not looked at; pairs:
    objects of the first and of the second visit that were taken for the same.
    """

    grounded_1: tuple[int, ...] | None
    grounded_2: tuple[int, ...]
    pairs: tuple[tuple[int, int], ...] = ()

    def to_json(self) -> dict[str, Any]:
        """{"grounded": {"first": [i] or null, "second": [j]}, "pairs": [[i, j]]}."""
        first = None if self.grounded_1 is None else list(self.grounded_1)
        return {"grounded": {"first": first, "second": list(self.grounded_2)}, "pairs": [list(pair) for pair in self.pairs]}

    @staticmethod
    def from_json(record: Any) -> Evidence:
        """The inverse of ``to_json``. Raises KeyError for a missing key."""
        first = record["grounded"]["first"]
        return Evidence(
            None if first is None else tuple(first),
            tuple(record["grounded"]["second"]),
            tuple((i, j) for i, j in record["pairs"]),
        )


def two_visits(
    relation: Relation,
    map_1: ObjectMap,
    map_2: ObjectMap,
    grounded_1: Sequence[int],
    grounded_2: Sequence[int],
    constants: ReferenceConstants,
) -> tuple[Answer | Abstention, Evidence]:
    """What the two-visit agent answers from its maps of both visits, and from which evidence.

    grounded_1, grounded_2: indices of what the noun means in each map. Abstains with NOTHING_GROUNDED where that is nothing in
    either, else as ``decide`` and, for MOVING, ``moving_by_last_sighting`` do. The order of a map's objects is of no
    consequence. Source: Eq. cost, Eq. pad, Eq. rules.
    """
    g_1, g_2 = list(grounded_1), list(grounded_2)
    p_1, p_2 = map_1.p[g_1], map_2.p[g_2]
    matched = _associated(map_1, map_2, g_1, g_2, constants.association)
    evidence = Evidence(tuple(g_1), tuple(g_2), tuple((g_1[i], g_2[j]) for i, j in matched.pairs))
    if not g_1 and not g_2:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), evidence
    if Relation(relation) is Relation.MOVING:
        tracks, last_seen = [map_2.tracks[j] for j in g_2], [map_2.last_seen[j] for j in g_2]
        return moving_by_last_sighting(tracks, last_seen, matched), evidence
    return decide(relation, p_1, p_2, matched, (), constants.decision), evidence


def two_visits_asked(
    relation: Relation, map_1: ObjectMap, map_2: ObjectMap, phrase: np.ndarray, constants: ReferenceConstants
) -> tuple[Answer | Abstention, Evidence]:
    """``two_visits``, with what the noun phrase of this unit embedding (K,) means by the features of the maps."""
    means = [grounded(objects.f, phrase, constants.similarity_margin) for objects in (map_1, map_2)]
    return two_visits(relation, map_1, map_2, *means, constants)


def two_visits_recorded(query: Query, recorded: Recorded, maps: Sequence[ObjectMap]) -> tuple[Answer | Abstention, Evidence]:
    """``two_visits`` on maps of the first and the second visit, with what the query's noun means in them (``means_of``)."""
    means = [means_of(query, recorded, which, objects) for which, objects in zip(VISITS, maps, strict=True)]
    return two_visits(query.relation, *maps, *means, ReferenceConstants.of(recorded.constants))


def means_of(query: Query, recorded: Recorded, which: str, objects: ObjectMap) -> tuple[int, ...]:
    """Which objects of a map of the visit `which` the query's noun means: by their features, or as it is handed over."""
    if recorded.grounding is Source.HANDED:
        return recorded.true_objects(which, objects.p)
    return grounded(objects.f, recorded.noun(noun(query.category)), recorded.constants.grounding.similarity_margin)


def one_visit(
    relation: Relation, map_2: ObjectMap, grounded_2: Sequence[int], reachable: ArrayLike
) -> tuple[UniformPick | UniformBox | Abstention, Evidence]:
    """What the single-visit agent picks from, given its map of the second visit, and from which evidence.

    grounded_2: indices of what the noun means in the map; reachable (K, 2): positions in metres that the agent can reach.
    Current relations are answered with the place of a grounded object, MOVING with its last track point; past ones, for which
    the visit holds no evidence, with a position in the bounding box of what is reachable. Abstains with NOTHING_GROUNDED where
    a current relation finds nothing grounded. Raises ValueError as ``single_visit`` does.
    Source: the single-visit baseline of the paper's problem formulation.
    """
    relation, evidence = Relation(relation), Evidence(None, tuple(grounded_2))
    if not relation.past and not evidence.grounded_2:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), evidence
    places = [map_2.tracks[j] if relation is Relation.MOVING else map_2.p[[j]] for j in evidence.grounded_2]
    return single_visit(relation, places, reachable), evidence


def _associated(
    map_1: ObjectMap, map_2: ObjectMap, g_1: list[int], g_2: list[int], constants: AssociationConstants
) -> Association:
    return associate(
        map_1.p[g_1],
        map_2.p[g_2],
        map_1.f[g_1],
        map_2.f[g_2],
        gate_m=constants.gate_m,
        feature_scale_m=constants.feature_scale_m,
    )
