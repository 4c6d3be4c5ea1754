"""Which certified trials may be released beside each other: no two episodes are seen in the same pair of tours. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

import numpy as np

from ovman.records.relation import Relation
from ovman.records.trial import Trial

TourPair = tuple[str, frozenset[str]]
"""A scene and the names of the recorded tours of its two visits, whichever comes first."""


def tour_pair(trial: Trial) -> TourPair:
    """The pair of tours of a trial; read backwards it is the same pair. ValueError for a trial that ended before its tours."""
    visits = trial.measured.visits
    if visits is None:
        raise ValueError(f"{trial.candidate.id}: the trial ended early and has no tours")
    return trial.candidate.scene, frozenset((visits.first, visits.second))


def independent(
    pairs: Mapping[str, TourPair], relation_of: Mapping[str, Relation], wanted: Mapping[Relation, int], rng: np.random.Generator
) -> list[str]:
    """Those of the trials that are left when each pair of tours serves one, sorted; every pair serves one.

    pairs: by the id of a trial. A pair that several relations could use goes to the one that lacks most of what is `wanted`,
    pairs in random order within scene after scene, so that neither relation is left with the better scenes. Of trials of one
    relation the first is taken.
    """
    claims: dict[TourPair, dict[Relation, str]] = {}
    for k in sorted(pairs):
        claims.setdefault(pairs[k], {}).setdefault(relation_of[k], k)
    kept = [k for claim in claims.values() if len(claim) == 1 for k in claim.values()]
    has = Counter(relation_of[k] for k in kept)
    contested = sorted((pair for pair, claim in claims.items() if len(claim) > 1), key=lambda pair: (pair[0], sorted(pair[1])))
    order = sorted(rng.permutation(len(contested)), key=lambda k: contested[k][0])
    for pair in (contested[k] for k in order):
        claim = claims[pair]
        lacks_most = max((r for r in Relation if r in claim), key=lambda r: wanted[r] - has[r])
        has[lacks_most] += 1
        kept.append(claim[lacks_most])
    return sorted(kept)


def left_out(pairs: Mapping[str, TourPair], released: Iterable[str]) -> list[str]:
    """The trials, in their order, that are not released because the pair of tours that they were seen in is."""
    released = set(released)
    taken = {pairs[k] for k in released}
    return [k for k, pair in pairs.items() if k not in released and pair in taken]
