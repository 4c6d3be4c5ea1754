"""Which instance of the first visit is which of the second: the least travelled distance within each cluster."""

from __future__ import annotations

import numpy as np

from ovman.agents.react.clusters import clusters
from ovman.agents.react.instances import Instances
from ovman.agents.reference.assignment import assigned
from ovman.agents.reference.association import Association, distances


def matched(first: Instances, second: Instances, appearance: float) -> Association:
    """Matched instances, absent ones (unmatched_1) and new ones (unmatched_2).

    In a cluster as many instances are matched as there are in the visit with fewer, so that they travelled least in all.
    """
    pairs: list[tuple[int, int]] = []
    for cluster in clusters(first, second, appearance):
        old, new = (_by_place(visit, of) for visit, of in ((first, cluster.first), (second, cluster.second)))
        if len(old) and len(new):
            rows, columns = assigned(distances(first.place[old], second.place[new]))
            pairs += zip(old[rows].tolist(), new[columns].tolist(), strict=True)
    known, seen_again = {i for i, _ in pairs}, {j for _, j in pairs}
    return Association(
        pairs=tuple(sorted(pairs)),
        unmatched_1=tuple(i for i in range(len(first)) if i not in known),
        unmatched_2=tuple(j for j in range(len(second)) if j not in seen_again),
    )


def _by_place(visit: Instances, of: tuple[int, ...]) -> np.ndarray:
    """Numbers (N,) of instances by their places: among equal optima the assignment does not depend on their numbers."""
    numbers = np.array(of, np.int64)
    ordered: np.ndarray = numbers[np.lexsort(visit.place[numbers].T[::-1])]
    return ordered
