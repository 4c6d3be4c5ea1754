"""Which certified trials a split releases: one per pair of tours, scenes in turn; or all of crossed world pairs. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ovman.generation.crossed import limit
from ovman.records.task import Query, Relation
from ovman.records.trial import Trial

TourPair = tuple[str, frozenset[str]]
"""A scene and the names of the recorded tours of its two visits, in any order."""


def select_in_turn(
    certified: Mapping[str, Sequence[str]],
    wanted: int,
    rng: np.random.Generator,
) -> list[str]:
    """Return `wanted` of the certified ids: scene after scene in random order, one id per scene and round."""
    order = sorted(certified)
    queues = {scene: [sorted(certified[scene])[k] for k in rng.permutation(len(certified[scene]))] for scene in order}
    scenes = [order[k] for k in rng.permutation(len(order))]
    turns = sorted((number, place, k) for place, scene in enumerate(scenes) for number, k in enumerate(queues[scene]))
    return [k for _, _, k in turns][:wanted]


def tour_pair(trial: Trial) -> TourPair:
    """Return the pair of tours of a certified trial, in any order."""
    visits = trial.measured.visits
    assert visits is not None
    return trial.candidate.scene, frozenset((visits.first, visits.second))


def select_independent(
    pairs: Mapping[str, TourPair], relation_of: Mapping[str, Relation], wanted: Mapping[Relation, int], rng: np.random.Generator
) -> list[str]:
    """Return the trials that remain when each pair of tours serves one trial, sorted.

    pairs: by the id of a trial. A pair that several relations could use goes to the relation that lacks most of its `wanted`
    number; pairs are in random order within each scene, so that no relation gets the better scenes. Of trials of one relation the
    first is taken.
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


def find_sharing(pairs: Mapping[str, TourPair], released: Iterable[str]) -> list[str]:
    """Return the unreleased trials whose pair of tours serves a released one, in their order."""
    released = set(released)
    taken = {pairs[k] for k in released}
    return [k for k, pair in pairs.items() if k not in released and pair in taken]


def select_crossed(certified: Iterable[Trial], fewest: int, most: int) -> list[str]:
    """Return the ids of certified trials that are crossed within their world pair: `fewest` to `most` of each pair, or none."""
    pairs: dict[str, dict[Query, str]] = {}
    for trial in certified:
        candidate = trial.candidate
        pairs.setdefault(candidate.streams, {})[Query(candidate.category, candidate.relation)] = candidate.id
    kept = {pair: limit(queries, most) for pair, queries in pairs.items()}
    return [
        name
        for pair, queries in pairs.items()
        for query, name in queries.items()
        if query in kept[pair] and len(kept[pair]) >= fewest
    ]
