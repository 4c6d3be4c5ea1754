"""The map of a visit: detections of one tour, clustered on the floor plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """One instance in one view.

    view: index in the tour; point (3,): position in the world, metres (`backprojection.median_points`); feature (K,): unit
    embedding of its crop.
    """

    view: int
    point: np.ndarray
    feature: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """One object of a map: (p, f, T) of the paper.

    position (2,): x and z of the median of its points, metres; feature (K,): mean of its embeddings, of unit length;
    track (T, 2): x and z of its detections in the order of the tour; views (T,): their views; members (T,): their numbers among
    all detections of the map.
    """

    position: np.ndarray
    feature: np.ndarray
    track: np.ndarray
    views: np.ndarray
    members: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def last_seen(self) -> int:
        """The last view in which it was detected."""
        return int(self.views[-1])


@dataclass(frozen=True, slots=True, eq=False)
class ObjectMap:
    """M_v of the paper as arrays, N objects.

    p (N, 2): floor-plane positions (x, z), metres; f (N, K): unit features; tracks: of each object its positions (T, 2), T >= 1,
    in the order they were seen; last_seen: index of the view it was last seen in; members: of each object the numbers of its
    detections among all of the map; empty if unknown.
    """

    p: np.ndarray
    f: np.ndarray
    tracks: tuple[np.ndarray, ...]
    last_seen: tuple[int, ...]
    members: tuple[np.ndarray, ...] = ()

    @staticmethod
    def of(clusters: Sequence[Cluster]) -> ObjectMap:
        """Return the arrays of a visit's clusters, in their order."""
        return ObjectMap(
            p=np.array([c.position for c in clusters], dtype=np.float64).reshape(-1, 2),
            f=np.stack([c.feature for c in clusters]).astype(np.float64) if clusters else np.zeros((0, 0)),
            tracks=tuple(np.asarray(c.track, dtype=np.float64) for c in clusters),
            last_seen=tuple(c.last_seen for c in clusters),
            members=tuple(c.members for c in clusters),
        )

    def __len__(self) -> int:
        return len(self.p)


def clusters(detections: Sequence[Detection], radius_m: float) -> tuple[Cluster, ...]:
    """Cluster detections greedily.

    Each detection, in the order of the tour, joins the nearest cluster whose median lies within `radius_m` on the floor plane, or
    begins one. Source: the paper's perception stage; epsilon of Table params.
    """
    members: list[list[int]] = []
    centres: list[np.ndarray] = []
    for number, detection in enumerate(detections):
        here = detection.point[[0, 2]]
        gaps = np.linalg.norm(np.array(centres) - here, axis=1) if centres else np.array([np.inf])
        nearest = int(gaps.argmin())
        if gaps[nearest] <= radius_m:
            members[nearest].append(number)
            centres[nearest] = np.median([detections[k].point[[0, 2]] for k in members[nearest]], axis=0)
        else:
            members.append([number])
            centres.append(here)
    return tuple(_cluster(detections, numbers, centre) for numbers, centre in zip(members, centres, strict=True))


def _cluster(detections: Sequence[Detection], numbers: Sequence[int], centre: np.ndarray) -> Cluster:
    group = [detections[k] for k in numbers]
    feature = np.mean([d.feature for d in group], axis=0)
    length = np.linalg.norm(feature)
    return Cluster(
        position=centre,
        feature=feature / length if length > 0 else feature,
        track=np.array([d.point[[0, 2]] for d in group]),
        views=np.array([d.view for d in group]),
        members=np.array(numbers, np.int64),
    )
