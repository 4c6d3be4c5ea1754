"""DualMap's local (concrete) map: observations of keyframes are matched to objects, which settle or go.

An object is updated, then either waiting and kept, or pending and removed. Source: DualMap's concrete map and its object status.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from ovman.agents.dualmap.cloud import FLOOR, Cloud, box_iou, thin
from ovman.agents.dualmap.observations import ObjectObservation
from ovman.agents.dualmap.settings import DualmapLife, DualmapLocal


class LocalMap:
    """The map of one run. Its keyframes are numbered from 0.

    A settled object is never deleted or moved; at a new place it becomes a new entry. kinds: number of classes; draws: random
    names of the objects.
    """

    def __init__(self, kinds: int, constants: DualmapLocal, draws: np.random.Generator) -> None:
        self.objects: list[MapObject] = []
        self.frame = -1
        self._kinds, self._constants, self._draws = kinds, constants, draws

    def copy(self, draws: np.random.Generator) -> LocalMap:
        """Return an independent copy; `draws` names its new objects."""
        other = LocalMap(self._kinds, self._constants, draws)
        other.objects = [thing.copy() for thing in self.objects]
        other.frame = self.frame
        return other

    def observe(self, seen: Sequence[RunObservation]) -> None:
        """Process one keyframe. Observations are matched to the map before it; several may match one object."""
        self.frame += 1
        touched = set()
        before = len(self.objects)
        for one, match in zip(seen, match_objects(seen, self.objects, self._constants), strict=True):
            if match is None:
                self.objects.append(MapObject.of(self._uid(), [one], [self.frame], self._constants))
            else:
                self.objects[match].add(one, self.frame, self._constants)
                touched.add(match)
        for index in sorted(touched):
            self._split(index)
        self._advance(before)

    def flush(self) -> None:
        """Process empty keyframes until every object has settled or gone."""
        for _ in range(flush_frames(self._constants.life)):
            self.observe(())

    def _uid(self) -> int:
        return int(self._draws.integers(2**63))

    def _split(self, index: int) -> None:
        whole = self.objects[index]
        if whole.frames[-2] != self.frame:
            return
        pair = find_common_pair(whole, self.frame - self._constants.split_window + 1)
        if pair is not None and pair[2] > self._constants.split_frames:
            self.objects[index], other = split(whole, pair[0], pair[1], self._uid(), self._constants)
            self.objects.append(other)

    def _advance(self, before: int) -> None:
        life = self._constants.life
        for thing in self.objects[:before]:
            missed = self.frame - thing.last_seen
            if missed <= life.window:
                thing.stage = Stage()
            elif thing.stage.phase is not Phase.SETTLED:
                entering = thing.stage.phase is Phase.UPDATING
                thing.stage = advance(thing.stage, missed, entering and self._is_stable(thing), life)
        self.objects = [thing for thing in self.objects if thing.stage.phase is not Phase.GONE]

    def _is_stable(self, thing: MapObject) -> bool:
        classes, confidences = [s.class_id for s in thing.seen], [s.confidence for s in thing.seen]
        return is_stable(classes, confidences, self._kinds, self._constants.life)


def match_objects(seen: Sequence[RunObservation], objects: Sequence[MapObject], constants: DualmapLocal) -> list[int | None]:
    """Return the index of the matching object for each observation, None for a new object.

    Similarity is spatial (fraction of the observation's points near the object's cloud, 0 if the boxes hardly overlap) plus
    visual (cosine of the features). An observation matches the most similar object if the similarity is above `match`; ties go
    to the first. As `match` is at least 1, features alone match nothing.
    """
    if not seen or not objects:
        return [None] * len(seen)
    overlapping = box_iou(np.stack([one.cloud.box for one in seen]), np.stack([thing.box for thing in objects]))
    return [
        _match(one, [(j, objects[j]) for j in np.flatnonzero(row >= constants.least_iou).tolist()], constants)
        for one, row in zip(seen, overlapping, strict=True)
    ]


def _match(one: RunObservation, objects: Sequence[tuple[int, MapObject]], constants: DualmapLocal) -> int | None:
    possible = []
    for j, thing in objects:
        visual = float(one.feature @ thing.feature)
        # No more points can be near an object's cloud than lie in its box.
        if visual + 1.0 > constants.match:
            possible.append((visual + one.cloud.share_inside(thing.box, constants.near_m), j, visual, thing))
    best, most = None, constants.match
    for greatest, j, visual, thing in sorted(possible, key=lambda each: (-each[0], each[1])):
        if greatest < most:
            break
        similarity = visual + thing.share_near(one.cloud, constants.near_m)
        if similarity > most or (similarity == most and best is not None and j < best):
            best, most = j, similarity
    return best


# Life cycle -------------------------------------------------------------------------------------------------------------------


class Phase(StrEnum):
    """Phase of an object.

    UPDATING: seen within the window. PENDING: unstable and not seen within it. WAITING: stable and not seen within it. SETTLED:
    final, after waiting long enough. GONE: pending for too long.
    """

    UPDATING = "updating"
    PENDING = "pending"
    WAITING = "waiting"
    SETTLED = "settled"
    GONE = "gone"


@dataclass(frozen=True, slots=True)
class Stage:
    """A phase and its duration in keyframes."""

    phase: Phase = Phase.UPDATING
    frames: int = 0


def advance(stage: Stage, missed: int, stable: bool, constants: DualmapLife) -> Stage:
    """Return the stage of an object after a keyframe.

    missed: keyframes since the last observation, 0 if this one has it; stable: as `is_stable`.
    """
    if missed <= constants.window:
        return Stage()
    if stage.phase is Phase.UPDATING:
        return Stage(Phase.WAITING if stable else Phase.PENDING, 1)
    frames = stage.frames + 1
    if stage.phase is Phase.PENDING and frames > constants.pending:
        return Stage(Phase.GONE)
    if stage.phase is Phase.WAITING and frames > constants.waiting:
        return Stage(Phase.SETTLED)
    return Stage(stage.phase, frames)


def flush_frames(constants: DualmapLife) -> int:
    """Return the number of empty keyframes after which every object has settled or gone."""
    return constants.window + max(constants.pending, constants.waiting) + 1


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
    history = _posteriors(classes, confidences, kinds)
    greatest = history.max(axis=1)
    last = history[-1]
    entropy = -float(np.sum(last * np.log(np.maximum(last, 1e-300))))
    recent = greatest[-constants.filter_span :]
    return bool(
        greatest[-1] > constants.filter_probability
        and entropy < constants.filter_entropy
        and len(recent) == constants.filter_span
        and recent.max() - recent.min() < constants.filter_change
    )


def _posteriors(classes: Sequence[int], confidences: Sequence[float], kinds: int) -> np.ndarray:
    """Return the probabilities (N, kinds) of the classes after each of N observations."""
    kinds = max(kinds, max(classes) + 1, 2)
    likelihood = np.empty((len(classes), kinds))
    sure = np.clip(np.asarray(confidences, dtype=np.float64), 1e-6, 1 - 1e-6)
    likelihood[:] = ((1 - sure) / (kinds - 1))[:, None]
    likelihood[np.arange(len(classes)), list(classes)] = sure
    log = np.cumsum(np.log(likelihood), axis=0)
    log -= log.max(axis=1, keepdims=True)
    weight = np.exp(log)
    probabilities: np.ndarray = weight / weight.sum(axis=1, keepdims=True)
    return probabilities


# Objects ----------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class RunObservation:
    """One observation with the cloud of one run. number: among all observations of its dense tour."""

    class_id: int
    confidence: float
    feature: np.ndarray
    cloud: Cloud
    number: int = 0

    @staticmethod
    def of(observation: ObjectObservation, run: int, cloud: Cloud | None = None) -> RunObservation:
        """Return the observation for the run of that number. cloud: the cloud of its points, if it exists already."""
        return RunObservation(
            observation.class_id,
            observation.confidence,
            np.asarray(observation.feature, dtype=np.float64),
            Cloud.of(observation.clouds[run]) if cloud is None else cloud,
            observation.number,
        )


@dataclass(slots=True, eq=False)
class MapObject:
    """An object of a local map.

    Attributes:
        uid: Random number that orders saved maps.
        seen: Its observations, at least one.
        frames: Their keyframes.
        parts: Its cloud in pieces, first the last thinned cloud, then later observations.
        total: Sum of its features.
        box: (6,) least x, y, z and greatest x, y, z, metres.
        stage: Of its life cycle.
    """

    uid: int
    seen: list[RunObservation]
    frames: list[int]
    parts: list[Cloud]
    total: np.ndarray
    box: np.ndarray
    stage: Stage = field(default_factory=Stage)

    @staticmethod
    def of(uid: int, seen: Sequence[RunObservation], frames: Sequence[int], constants: DualmapLocal) -> MapObject:
        """Return the object of these observations, in their order."""
        first = seen[0]
        made = MapObject(uid, [first], [frames[0]], [first.cloud], first.feature.copy(), first.cloud.box)
        for observation, frame in zip(seen[1:], frames[1:], strict=True):
            made.add(observation, frame, constants)
        return made

    def copy(self) -> MapObject:
        """Return an independent copy."""
        seen, frames, parts = list(self.seen), list(self.frames), list(self.parts)
        return MapObject(self.uid, seen, frames, parts, self.total.copy(), self.box, self.stage)

    def add(self, seen: RunObservation, frame: int, constants: DualmapLocal) -> None:
        """Add an observation: its cloud, thinned at every `thin_every`-th, and its feature."""
        self.seen.append(seen)
        self.frames.append(frame)
        self.total += seen.feature
        self.parts.append(seen.cloud)
        if len(self.seen) % constants.thin_every == 0:
            self.parts = [Cloud(thin(self.columns, constants.voxel_m))]
            self.box = self.parts[0].box
        else:
            box = seen.cloud.box
            self.box = np.concatenate([np.minimum(self.box[:3], box[:3]), np.maximum(self.box[3:], box[3:])])

    def share_near(self, cloud: Cloud, near_m: float) -> float:
        """Return the fraction of a cloud's points within near_m of this object's."""
        left = cloud.columns
        for part in self.parts:
            if left.shape[1]:
                left = left[:, ~part.near(left, near_m)]
        fraction: float = 1.0 - left.shape[1] / len(cloud)
        return fraction

    @property
    def columns(self) -> np.ndarray:
        """The cloud (3, N), metres, coordinate by coordinate."""
        return self.parts[0].columns if len(self.parts) == 1 else np.concatenate([part.columns for part in self.parts], axis=1)

    @property
    def feature(self) -> np.ndarray:
        """Mean (K,) of the observations' features, of unit length."""
        length = np.linalg.norm(self.total)
        return self.total / length if length > 0 else self.total

    @property
    def class_id(self) -> int:
        """The commonest class; of equally common ones the class that was seen first."""
        return Counter(seen.class_id for seen in self.seen).most_common(1)[0][0]

    @property
    def first_seen(self) -> int:
        """Keyframe of the first observation."""
        return self.frames[0]

    @property
    def last_seen(self) -> int:
        """Keyframe of the last observation."""
        return self.frames[-1]

    def members(self, frames: int = 0, observations: int = 0) -> np.ndarray:
        """Return the numbers of its observations.

        Those of keyframe `frames` and later are of a second dense tour: they count on from `observations`, the number that the
        first one has.
        """
        seen = zip(self.seen, self.frames, strict=True)
        return np.array([one.number + (observations if frame >= frames else 0) for one, frame in seen], np.int64)

    @property
    def position(self) -> np.ndarray:
        """Centre (x, z) of its box, metres."""
        centre: np.ndarray = (self.box[:3] + self.box[3:])[FLOOR] / 2
        return centre


def find_common_pair(thing: MapObject, since: int) -> tuple[int, int, int] | None:
    """Return the pair of classes that most keyframes from `since` on observe together, and in how many, the smaller class first.

    None if no keyframe has two classes.
    """
    kinds: dict[int, set[int]] = {}
    for seen, frame in zip(reversed(thing.seen), reversed(thing.frames), strict=True):
        if frame < since:
            break
        kinds.setdefault(frame, set()).add(seen.class_id)
    pairs = Counter((a, b) for classes in kinds.values() for a in classes for b in classes if a < b)
    if not pairs:
        return None
    (a, b), count = min(pairs.items(), key=lambda item: (-item[1], item[0]))
    return a, b, count


def split(whole: MapObject, a: int, b: int, uid: int, constants: DualmapLocal) -> tuple[MapObject, MapObject]:
    """Split an object into those of its classes a and b. The commoner class keeps the uid and observations of other classes."""
    counts = Counter(seen.class_id for seen in whole.seen)
    lesser = a if counts[a] < counts[b] else b

    def of(name: int, its: bool) -> MapObject:
        rows = [k for k, seen in enumerate(whole.seen) if (seen.class_id == lesser) is its]
        return MapObject.of(name, [whole.seen[k] for k in rows], [whole.frames[k] for k in rows], constants)

    return of(whole.uid, False), of(uid, True)
