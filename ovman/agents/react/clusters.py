"""Clusters of instances of one class that look alike, within a visit and across both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.react.instances import Instances


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Instances of both visits that look alike, by their numbers in their visits. feature (K,): mean over all views."""

    kind: int
    feature: np.ndarray
    views: int
    first: tuple[int, ...] = ()
    second: tuple[int, ...] = ()

    def with_other(self, other: Cluster) -> Cluster:
        """Both as one cluster."""
        views = self.views + other.views
        feature = (self.feature * self.views + other.feature * other.views) / views
        return Cluster(
            self.kind, feature, views, tuple(sorted(self.first + other.first)), tuple(sorted(self.second + other.second))
        )


def clusters(first: Instances, second: Instances, appearance: float) -> tuple[Cluster, ...]:
    """The clusters of the first visit, which those of the second visit's instances then join or stand beside."""
    known = merged([_alone(first, i, (i,), ()) for i in range(len(first))], appearance)
    return merged([*known, *(_alone(second, j, (), (j,)) for j in range(len(second)))], appearance)


def merged(found: Sequence[Cluster], appearance: float) -> tuple[Cluster, ...]:
    """Clusters of one class whose features are at most `appearance` apart are merged until there are none left.

    The nearest pair is merged first, so that the order of the clusters is of no consequence.
    """
    left = sorted(found, key=lambda cluster: (cluster.kind, *cluster.feature.tolist(), cluster.views))
    while True:
        pair = _nearest(left)
        if pair is None or pair[0] > appearance:
            return tuple(left)
        _, a, b = pair
        left = [one for k, one in enumerate(left) if k not in (a, b)] + [left[a].with_other(left[b])]


def _nearest(found: Sequence[Cluster]) -> tuple[float, int, int] | None:
    """Distance and indices of the two clusters of one class that are nearest to each other, the first in a tie."""
    if len(found) < 2:
        return None
    features, kinds = np.array([one.feature for one in found]), np.array([one.kind for one in found])
    apart = np.linalg.norm(features[:, None] - features[None], axis=2)
    apart[kinds[:, None] != kinds[None]] = np.inf
    apart[np.tril_indices(len(found))] = np.inf
    a, b = np.unravel_index(int(apart.argmin()), apart.shape)
    return (float(apart[a, b]), int(a), int(b)) if np.isfinite(apart[a, b]) else None


def _alone(visit: Instances, index: int, first: tuple[int, ...], second: tuple[int, ...]) -> Cluster:
    return Cluster(int(visit.kind[index]), visit.feature[index], int(visit.views[index]), first, second)
