"""Objects: the segments of a tour that show one instance at one place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ovman.agents.joint.naming import Nouns
from ovman.agents.joint.segments import Segments
from ovman.agents.joint.settings import Joint


@dataclass(frozen=True, slots=True, eq=False)
class Objects:
    """N objects of a tour. place (N, 3): median of its segments' places, metres; feature (N, K): unit mean of their embeddings,
    zeros for one without a detection; named (N,): log probability that it is what the noun means; changed (N,): log odds that
    its place is otherwise in the other tour; views (N,): in how many frames it is seen."""

    place: np.ndarray
    feature: np.ndarray
    named: np.ndarray
    changed: np.ndarray
    views: np.ndarray

    def __len__(self) -> int:
        return len(self.place)


def objects(seen: Segments, phrase: str | None, nouns: Nouns, constants: Joint) -> Objects:
    """The objects of a tour's segments. phrase: the noun that is asked for, None where it is withheld."""
    named = np.flatnonzero(seen.named)
    parts = np.flatnonzero(~seen.named)
    groups = _together(seen, named, constants)
    known = [np.median(seen.place[group], axis=0) for group in groups if _mean(seen, group, seen.changed) > 0]
    loose = [k for k in parts if all(np.linalg.norm(seen.place[k] - place) > constants.radius_m for place in known)]
    groups += _together(seen, np.array(loose, np.int64), constants)
    log = nouns.log_probability(seen.feature, phrase) if phrase else np.full(len(seen), nouns.chance)
    feature = [_unit(np.average(seen.feature[group], axis=0, weights=_weights(seen, group))) for group in groups]
    views = np.array([len(np.unique(seen.view[group])) for group in groups], np.int64)
    share = views / (views + constants.views)
    pooled = np.array([_mean(seen, group, log) for group in groups])
    return Objects(
        place=np.array([np.median(seen.place[group], axis=0) for group in groups]).reshape(len(groups), 3),
        feature=np.array(feature).reshape(len(groups), seen.feature.shape[1]),
        named=share * pooled + (1 - share) * nouns.chance,
        changed=np.array([_mean(seen, group, seen.changed) for group in groups]),
        views=views,
    )


def _together(seen: Segments, chosen: np.ndarray, constants: Joint) -> list[np.ndarray]:
    """The groups of the chosen segments: average linkage over the distance of their places and that of their features."""
    if len(chosen) < 2:
        return [chosen] if len(chosen) else []
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    place, feature = seen.place[chosen], seen.feature[chosen]
    apart = np.linalg.norm(place[:, None] - place[None], axis=2) / constants.radius_m
    if seen.named[chosen].all():
        apart += np.maximum(1 - feature @ feature.T, 0) / constants.feature_distance
    np.fill_diagonal(apart, 0)
    of = fcluster(linkage(squareform((apart + apart.T) / 2, checks=False), "average"), 1.0, "distance")
    return [chosen[of == k] for k in np.unique(of)]


def _weights(seen: Segments, group: np.ndarray) -> np.ndarray:
    """Larger segments say more, but not in proportion to their areas: pixels of one view are not independent."""
    weights: np.ndarray = np.sqrt(seen.cells[group])
    return weights


def _mean(seen: Segments, group: np.ndarray, values: np.ndarray) -> float:
    return float(np.average(values[group], weights=_weights(seen, group)))


def _unit(vector: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vector)
    return vector / length if length > 0 else vector
