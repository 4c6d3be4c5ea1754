"""DualMap's local (concrete) map: observations of keyframes are matched to objects, and unstable objects are forgotten.

Source: DualMap's concrete map and its object status.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.dualmap import DualmapLife, DualmapLocal
from ovman.agents.dualmap.cloud import Cloud, box_iou


class LocalMap:
    """The map of one run. Its keyframes, and all observations of them, are numbered from 0.

    An object that stays is never moved; at a new place it becomes a new entry. kinds: number of classes; draws: random names of
    the objects.
    """

    def __init__(self, kinds: int, constants: DualmapLocal, draws: np.random.Generator) -> None:
        self.objects: list[MapObject] = []
        self.keyframes, self.observations = 0, 0
        self._kinds, self._constants, self._draws = kinds, constants, draws

    def copy(self, draws: np.random.Generator) -> LocalMap:
        """Return an independent copy; `draws` names its new objects."""
        other = LocalMap(self._kinds, self._constants, draws)
        other.objects = [thing.copy() for thing in self.objects]
        other.keyframes, other.observations = self.keyframes, self.observations
        return other

    def observe(self, seen: Sequence[Sight]) -> None:
        """Process one keyframe. Observations are matched to the map before it; several may match one object."""
        touched = set()
        for one, match in zip(seen, match_objects(seen, self.objects, self._constants), strict=True):
            observation = Observed(one, self.keyframes, self.observations)
            self.observations += 1
            if match is None:
                self.objects.append(MapObject.of(self._uid(), [observation], self._constants))
            else:
                self.objects[match].add(observation, self._constants)
                touched.add(match)
        for index in sorted(touched):
            self._split(index)
        life = self._constants.life
        self.objects = [
            thing
            for thing in self.objects
            if self.keyframes - thing.last_seen != life.window + life.pending + 1 or self._is_stable(thing)
        ]
        self.keyframes += 1

    def finish(self) -> list[MapObject]:
        """Return the objects that stay if nothing more is observed, in the order of their names."""
        return sorted(filter(self._is_stable, self.objects), key=lambda thing: thing.uid)

    def _uid(self) -> int:
        return int(self._draws.integers(2**63))

    def _split(self, index: int) -> None:
        whole = self.objects[index]
        if whole.seen[-2].keyframe != self.keyframes:
            return
        pair = find_common_pair(whole, self.keyframes - self._constants.split_window + 1)
        if pair is not None and pair[2] > self._constants.split_frames:
            self.objects[index], other = split(whole, pair[0], pair[1], self._uid(), self._constants)
            self.objects.append(other)

    def _is_stable(self, thing: MapObject) -> bool:
        sights = [observed.sight for observed in thing.seen]
        classes, confidences = [one.class_id for one in sights], [one.confidence for one in sights]
        return is_stable(classes, confidences, self._kinds, self._constants.life)


def match_objects(seen: Sequence[Sight], objects: Sequence[MapObject], constants: DualmapLocal) -> list[int | None]:
    """Return the index of the matching object for each observation, None for a new object.

    Similarity is spatial (fraction of the observation's points near the object's cloud, 0 if the boxes hardly overlap) plus
    visual (cosine of the features). An observation matches the most similar object if the similarity is above `match`; ties go
    to the first. As `match` is at least 1, features alone match nothing.
    """
    if not seen or not objects:
        return [None] * len(seen)
    overlapping = box_iou(np.stack([one.cloud.box for one in seen]), np.stack([thing.box for thing in objects]))
    matches: list[int | None] = []
    for one, overlap in zip(seen, overlapping, strict=True):
        best, most = None, constants.match
        for j in np.flatnonzero(overlap >= constants.least_iou).tolist():
            visual = float(one.feature @ objects[j].feature)
            if visual + 1.0 > most and (similarity := visual + objects[j].share_near(one.cloud, constants.near_m)) > most:
                best, most = j, similarity
        matches.append(best)
    return matches


# Life of an object ------------------------------------------------------------------------------------------------------------


def is_stable(classes: Sequence[int], confidences: Sequence[float], kinds: int, constants: DualmapLife) -> bool:
    """Say whether an object was observed often enough and with a consistent class.

    classes, confidences: of its observations in their order; kinds: number of classes.
    """
    if len(classes) < constants.stable:
        return False
    _, most = Counter(classes).most_common(1)[0]
    return most * constants.majority_one_in > len(classes) or has_converged(classes, confidences, kinds, constants)


def has_converged(classes: Sequence[int], confidences: Sequence[float], kinds: int, constants: DualmapLife) -> bool:
    """Say whether a Bayes filter over an object's class has converged.

    The likelihood of an observation is its confidence for its own class; the others share the rest equally. The prior over the
    `kinds` classes is uniform.
    """
    kinds = max(kinds, max(classes) + 1, 2)
    sure = np.clip(np.asarray(confidences, dtype=np.float64), 1e-6, 1 - 1e-6)
    likelihood = np.tile(((1 - sure) / (kinds - 1))[:, None], kinds)
    likelihood[np.arange(len(classes)), list(classes)] = sure
    log = np.cumsum(np.log(likelihood), axis=0)
    weight = np.exp(log - log.max(axis=1, keepdims=True))
    history = weight / weight.sum(axis=1, keepdims=True)
    greatest, last = history.max(axis=1), history[-1]
    entropy = -float(np.sum(last * np.log(np.maximum(last, 1e-300))))
    recent = greatest[-constants.filter_span :]
    return bool(
        greatest[-1] > constants.filter_probability
        and entropy < constants.filter_entropy
        and len(recent) == constants.filter_span
        and recent.max() - recent.min() < constants.filter_change
    )


# Objects ----------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """One run's observation of an object in a frame: class, confidence, feature (K,) and cloud."""

    class_id: int
    confidence: float
    feature: np.ndarray
    cloud: Cloud


@dataclass(frozen=True, slots=True, eq=False)
class Observed:
    """An observation of an object of a map: its keyframe, and its number among all observations of the map."""

    sight: Sight
    keyframe: int
    number: int


@dataclass(slots=True, eq=False)
class MapObject:
    """An object of a local map.

    Attributes:
        uid: Random number that orders saved maps.
        seen: Its observations, at least one.
        parts: Its cloud in pieces, first the last thinned cloud, then later observations.
        total: Sum of its features.
        box: (6,) least x, y, z and greatest x, y, z, metres.
    """

    uid: int
    seen: list[Observed]
    parts: list[Cloud]
    total: np.ndarray
    box: np.ndarray

    @staticmethod
    def of(uid: int, seen: Sequence[Observed], constants: DualmapLocal) -> MapObject:
        """Return the object of these observations, in their order."""
        first = seen[0].sight
        made = MapObject(uid, [seen[0]], [first.cloud], first.feature.copy(), first.cloud.box)
        for observed in seen[1:]:
            made.add(observed, constants)
        return made

    def copy(self) -> MapObject:
        """Return an independent copy."""
        return MapObject(self.uid, [*self.seen], [*self.parts], self.total.copy(), self.box)

    def add(self, observed: Observed, constants: DualmapLocal) -> None:
        """Add an observation: its cloud, thinned at every `thin_every`-th, and its feature."""
        cloud = observed.sight.cloud
        self.seen.append(observed)
        self.total += observed.sight.feature
        self.parts.append(cloud)
        if len(self.seen) % constants.thin_every == 0:
            self.parts = [Cloud(self.columns).thin(constants.voxel_m)]
            self.box = self.parts[0].box
        else:
            self.box = np.concatenate([np.minimum(self.box[:3], cloud.box[:3]), np.maximum(self.box[3:], cloud.box[3:])])

    def share_near(self, cloud: Cloud, near_m: float) -> float:
        """Return the fraction of a cloud's points within near_m of this object's."""
        inside = left = cloud.inside(self.box, near_m)
        for part in self.parts:
            if left.shape[1]:
                left = left[:, ~part.near(left, near_m)]
        share: float = 1.0 - (len(cloud) - inside.shape[1] + left.shape[1]) / len(cloud)
        return share

    @property
    def columns(self) -> np.ndarray:
        """The cloud (3, N), metres, coordinate by coordinate."""
        return np.concatenate([part.columns for part in self.parts], axis=1)

    @property
    def feature(self) -> np.ndarray:
        """Mean (K,) of the observations' features, of unit length."""
        length = np.linalg.norm(self.total)
        return self.total / length if length > 0 else self.total

    @property
    def class_id(self) -> int:
        """The commonest class; of equally common ones the class that was seen first."""
        return Counter(observed.sight.class_id for observed in self.seen).most_common(1)[0][0]

    @property
    def last_seen(self) -> int:
        """Keyframe of the last observation."""
        return self.seen[-1].keyframe

    @property
    def position(self) -> np.ndarray:
        """Centre (x, z) of its box, metres."""
        centre: np.ndarray = (self.box[:3] + self.box[3:])[[0, 2]] / 2
        return centre


def find_common_pair(thing: MapObject, since: int) -> tuple[int, int, int] | None:
    """Return the pair of classes that most keyframes from `since` on observe together, and in how many, the smaller class first.

    None if no keyframe has two classes.
    """
    kinds: dict[int, set[int]] = {}
    for observed in thing.seen:
        if observed.keyframe >= since:
            kinds.setdefault(observed.keyframe, set()).add(observed.sight.class_id)
    pairs = Counter((a, b) for classes in kinds.values() for a in classes for b in classes if a < b)
    if not pairs:
        return None
    (a, b), count = min(pairs.items(), key=lambda item: (-item[1], item[0]))
    return a, b, count


def split(whole: MapObject, a: int, b: int, uid: int, constants: DualmapLocal) -> tuple[MapObject, MapObject]:
    """Split an object into those of its classes a and b. The commoner class keeps the uid and observations of other classes."""
    counts = Counter(observed.sight.class_id for observed in whole.seen)
    lesser = a if counts[a] < counts[b] else b
    rest = [observed for observed in whole.seen if observed.sight.class_id != lesser]
    apart = [observed for observed in whole.seen if observed.sight.class_id == lesser]
    return MapObject.of(whole.uid, rest, constants), MapObject.of(uid, apart, constants)
