"""The map of a visit: detections of one tour, clustered on the floor plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """One instance in one view.

    view: index in the tour; point (3,): position in the world, metres (`backprojection.median_point`); feature (K,): unit
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


def clusters(detections: Sequence[Detection], radius_m: float) -> tuple[Cluster, ...]:
    """Greedy clustering: each detection, in the order of the tour, joins the nearest cluster whose median lies within `radius_m`
    on the floor plane, or begins one. ValueError for a radius that is not positive or views that are out of order.

    Source: the paper's perception stage; epsilon of Table params.
    """
    if not radius_m > 0:
        raise ValueError(f"radius_m must be positive, not {radius_m}")
    if any(a.view > b.view for a, b in zip(detections, detections[1:], strict=False)):
        raise ValueError("detections come in the order of the tour")
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
