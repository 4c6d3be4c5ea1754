"""A visit's map as the arrays that the stages of the reference agent work on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.perception.clusters import Cluster


@dataclass(frozen=True, slots=True, eq=False)
class ObjectMap:
    """M_v of the paper, N objects: p (N, 2) floor-plane positions (x, z) in metres, f (N, K) unit features, tracks: for each
    object its positions (T, 2), T >= 1, in the order they were seen, last_seen: the index of the view it was last seen in,
    members: for each object the numbers of its detections among all of which the map was made; empty where it is not known.
    """

    p: np.ndarray
    f: np.ndarray
    tracks: tuple[np.ndarray, ...]
    last_seen: tuple[int, ...]
    members: tuple[np.ndarray, ...] = ()

    @staticmethod
    def of(clusters: Sequence[Cluster]) -> ObjectMap:
        """The arrays of a visit's clusters, in their order."""
        return ObjectMap(
            p=np.array([c.position for c in clusters], dtype=np.float64).reshape(-1, 2),
            f=np.stack([c.feature for c in clusters]).astype(np.float64) if clusters else np.zeros((0, 0)),
            tracks=tuple(np.asarray(c.track, dtype=np.float64) for c in clusters),
            last_seen=tuple(c.last_seen for c in clusters),
            members=tuple(c.members for c in clusters),
        )

    def __len__(self) -> int:
        return len(self.p)
