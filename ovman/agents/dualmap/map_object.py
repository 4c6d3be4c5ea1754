"""An object of the local map, grown from its observations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ovman.agents.dualmap.cloud import FLOOR, Cloud, thinned
from ovman.agents.dualmap.constants import LocalConstants
from ovman.agents.dualmap.life_cycle import Stage
from ovman.agents.dualmap.observation import Observation


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """One observation as one run has it. frame: index of the keyframe in the map's life; cloud: the points that the run drew."""

    frame: int
    class_id: int
    confidence: float
    feature: np.ndarray
    cloud: Cloud
    low_mobility: bool

    @staticmethod
    def of(observation: Observation, run: int, frame: int) -> Seen:
        """What the run of that number makes of an observation in the map's keyframe `frame`."""
        return Seen(
            frame,
            observation.class_id,
            observation.confidence,
            np.asarray(observation.feature, dtype=np.float64),
            Cloud(observation.clouds[run]),
            observation.low_mobility,
        )


@dataclass(slots=True, eq=False)
class MapObject:
    """uid: a random number, of which the order of a saved map comes; seen: its observations, at least one; parts: its cloud in
    pieces, first what was thinned last, then what came since; total: sum of its features; stage: where it is in its life.
    """

    uid: int
    seen: list[Seen]
    parts: list[Cloud]
    total: np.ndarray
    box: np.ndarray
    stage: Stage = field(default_factory=Stage)

    @staticmethod
    def of(uid: int, seen: Sequence[Seen], constants: LocalConstants) -> MapObject:
        """The object that these observations make, in their order."""
        first, *more = seen
        made = MapObject(uid, [first], [first.cloud], first.feature.copy(), first.cloud.box)
        for observation in more:
            made.add(observation, constants)
        return made

    def copy(self) -> MapObject:
        """An object of its own that grows independently."""
        return MapObject(self.uid, list(self.seen), list(self.parts), self.total.copy(), self.box, self.stage)

    def add(self, seen: Seen, constants: LocalConstants) -> None:
        """Append an observation's cloud, thinning at every `thin_every`-th, and its share of the running mean of the features."""
        self.seen.append(seen)
        self.total += seen.feature
        self.parts.append(seen.cloud)
        if len(self.seen) % constants.thin_every == 0:
            self.parts = [Cloud(thinned(self.points, constants.voxel_m))]
            self.box = self.parts[0].box
        else:
            self.box = np.concatenate(
                [np.minimum(self.box[:3], seen.cloud.box[:3]), np.maximum(self.box[3:], seen.cloud.box[3:])]
            )

    def shared(self, points: np.ndarray, near_m: float) -> float:
        """The fraction of `points` (N, 3) within near_m of this object's cloud."""
        left = points
        for part in self.parts:
            if len(left):
                left = left[~part.near(left, near_m)]
        return 1.0 - len(left) / len(points)

    @property
    def points(self) -> np.ndarray:
        """(N, 3), metres."""
        return self.parts[0].points if len(self.parts) == 1 else np.concatenate([part.points for part in self.parts])

    @property
    def feature(self) -> np.ndarray:
        """(K,) mean of the observations' features, of unit length."""
        length = np.linalg.norm(self.total)
        return self.total / length if length > 0 else self.total

    @property
    def class_id(self) -> int:
        """The commonest class, of equally common ones the one that was seen first."""
        return Counter(seen.class_id for seen in self.seen).most_common(1)[0][0]

    @property
    def low_mobility(self) -> bool:
        """Most of its observations are of furniture that seldom moves."""
        return 2 * sum(seen.low_mobility for seen in self.seen) > len(self.seen)

    @property
    def first_seen(self) -> int:
        return self.seen[0].frame

    @property
    def last_seen(self) -> int:
        return self.seen[-1].frame

    @property
    def position(self) -> np.ndarray:
        """(2,) x and z of the centre of its box, metres."""
        return (self.box[:3] + self.box[3:])[FLOOR] / 2


def together(seen: Sequence[Seen], since: int) -> tuple[int, int, int] | None:
    """The two classes that observations share most keyframes with, from keyframe `since` on: (class, class, keyframes), the
    smaller class first; None where no keyframe shows two.
    """
    frames: dict[int, set[int]] = {}
    for observation in reversed(seen):
        if observation.frame < since:
            break
        frames.setdefault(observation.frame, set()).add(observation.class_id)
    pairs = Counter((a, b) for kinds in frames.values() for a in kinds for b in kinds if a < b)
    if not pairs:
        return None
    (a, b), count = min(pairs.items(), key=lambda item: (-item[1], item[0]))
    return a, b, count


def parted(whole: MapObject, a: int, b: int, uid: int, constants: LocalConstants) -> tuple[MapObject, MapObject]:
    """An object as the two that its classes a and b say it is. The commoner keeps the name and what was seen as a third class."""
    counts = Counter(seen.class_id for seen in whole.seen)
    lesser = a if counts[a] < counts[b] else b
    mine = [seen for seen in whole.seen if seen.class_id != lesser]
    other = [seen for seen in whole.seen if seen.class_id == lesser]
    return MapObject.of(whole.uid, mine, constants), MapObject.of(uid, other, constants)
