"""Which certified trials a split releases: scenes in turn, or all of crossed world pairs. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ovman.generation.crossed import limit
from ovman.records.task import Query
from ovman.records.trial import Trial


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
