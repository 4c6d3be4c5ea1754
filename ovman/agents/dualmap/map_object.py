"""An object of the local map, grown from its observations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ovman.agents.dualmap.cloud import FLOOR, Cloud
from ovman.agents.dualmap.grid import thinned
from ovman.agents.dualmap.life_cycle import Stage
from ovman.agents.dualmap.observation import ObjectObservation
from ovman.agents.dualmap.settings import DualmapLocal


@dataclass(frozen=True, slots=True, eq=False)
class RunObservation:
    """One observation with the cloud of one run. number: among all observations of its walk."""

    class_id: int
    confidence: float
    feature: np.ndarray
    cloud: Cloud
    low_mobility: bool
    number: int = 0

    @staticmethod
    def of(observation: ObjectObservation, run: int, cloud: Cloud | None = None) -> RunObservation:
        """The observation for the run of that number. cloud: the cloud of its points, if it exists already."""
        return RunObservation(
            observation.class_id,
            observation.confidence,
            np.asarray(observation.feature, dtype=np.float64),
            Cloud.of(observation.clouds[run]) if cloud is None else cloud,
            observation.low_mobility,
            observation.number,
        )


@dataclass(slots=True, eq=False)
class MapObject:
    """An object of a local map.

    uid: random number that orders saved maps; seen: its observations, at least one; frames: their keyframes; parts: its cloud in
    pieces, first the last thinned cloud, then later observations; total: sum of its features; box (6,): least x, y, z and
    greatest x, y, z, metres; stage: of its life cycle.
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
        """The object of these observations, in their order."""
        first = seen[0]
        made = MapObject(uid, [first], [frames[0]], [first.cloud], first.feature.copy(), first.cloud.box)
        for observation, frame in zip(seen[1:], frames[1:], strict=True):
            made.add(observation, frame, constants)
        return made

    def copy(self) -> MapObject:
        """An independent copy."""
        seen, frames, parts = list(self.seen), list(self.frames), list(self.parts)
        return MapObject(self.uid, seen, frames, parts, self.total.copy(), self.box, self.stage)

    def add(self, seen: RunObservation, frame: int, constants: DualmapLocal) -> None:
        """Add an observation: its cloud, thinned at every `thin_every`-th, and its feature."""
        self.seen.append(seen)
        self.frames.append(frame)
        self.total += seen.feature
        self.parts.append(seen.cloud)
        if len(self.seen) % constants.thin_every == 0:
            self.parts = [Cloud(thinned(self.columns, constants.voxel_m))]
            self.box = self.parts[0].box
        else:
            box = seen.cloud.box
            self.box = np.concatenate([np.minimum(self.box[:3], box[:3]), np.maximum(self.box[3:], box[3:])])

    def shared(self, cloud: Cloud, near_m: float) -> float:
        """The fraction of a cloud's points within near_m of this object's."""
        left = cloud.columns
        for part in self.parts:
            if left.shape[1]:
                left = left[:, ~part.near(left, near_m)]
        fraction: float = 1.0 - left.shape[1] / len(cloud)
        return fraction

    @property
    def columns(self) -> np.ndarray:
        """(3, N), metres: the cloud, coordinate by coordinate."""
        return self.parts[0].columns if len(self.parts) == 1 else np.concatenate([part.columns for part in self.parts], axis=1)

    @property
    def feature(self) -> np.ndarray:
        """(K,) mean of the observations' features, of unit length."""
        length = np.linalg.norm(self.total)
        return self.total / length if length > 0 else self.total

    @property
    def class_id(self) -> int:
        """The commonest class; ties go to the one that was seen first."""
        return Counter(seen.class_id for seen in self.seen).most_common(1)[0][0]

    @property
    def low_mobility(self) -> bool:
        """Whether most of its observations are of furniture that seldom moves."""
        return 2 * sum(seen.low_mobility for seen in self.seen) > len(self.seen)

    @property
    def first_seen(self) -> int:
        """Keyframe of the first observation."""
        return self.frames[0]

    @property
    def last_seen(self) -> int:
        """Keyframe of the last observation."""
        return self.frames[-1]

    def members(self, frames: int = 0, observations: int = 0) -> np.ndarray:
        """(K,) numbers of its observations. Those of keyframe `frames` and later are of a second walk: they count on from
        `observations`, the number that the first one has.
        """
        seen = zip(self.seen, self.frames, strict=True)
        return np.array([one.number + (observations if frame >= frames else 0) for one, frame in seen], np.int64)

    @property
    def position(self) -> np.ndarray:
        """(2,) x and z of the centre of its box, metres."""
        centre: np.ndarray = (self.box[:3] + self.box[3:])[FLOOR] / 2
        return centre


def together(thing: MapObject, since: int) -> tuple[int, int, int] | None:
    """The pair of classes that most keyframes from `since` on observe together: (class, class, keyframes), the smaller class
    first; None if no keyframe has two classes.
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


def parted(whole: MapObject, a: int, b: int, uid: int, constants: DualmapLocal) -> tuple[MapObject, MapObject]:
    """The two objects of an object's classes a and b. The commoner class keeps the uid and observations of other classes."""
    counts = Counter(seen.class_id for seen in whole.seen)
    lesser = a if counts[a] < counts[b] else b

    def of(name: int, its: bool) -> MapObject:
        rows = [k for k, seen in enumerate(whole.seen) if (seen.class_id == lesser) is its]
        return MapObject.of(name, [whole.seen[k] for k in rows], [whole.frames[k] for k in rows], constants)

    return of(whole.uid, False), of(uid, True)
