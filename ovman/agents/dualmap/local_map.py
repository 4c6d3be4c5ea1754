"""DualMap's local (concrete) map: observations of keyframes are matched to objects, which settle or go.

Source: DualMap's concrete map. A settled object is never deleted or moved; at a new place it becomes a new entry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ovman.agents.dualmap.cloud import box_iou
from ovman.agents.dualmap.life_cycle import Phase, Stage, advanced, flush_frames, is_stable
from ovman.agents.dualmap.map_object import MapObject, RunObservation, parted, together
from ovman.agents.dualmap.relation import lies_on
from ovman.agents.dualmap.settings import DualmapGlobal, DualmapLocal


@dataclass(frozen=True, slots=True, eq=False)
class Departure:
    """Furniture that leaves the local map for the global one, with the objects on it."""

    object: MapObject
    related: tuple[MapObject, ...]


class LocalMap:
    """The map of one run. Its keyframes are numbered from 0.

    kinds: number of classes; draws: random names of the objects; handing_on: None keeps settled objects (local mapping only),
    else they leave, with the constants of the relation "on"; unknown: the class of what no name fits, or None.
    """

    def __init__(
        self,
        kinds: int,
        constants: DualmapLocal,
        draws: np.random.Generator,
        handing_on: DualmapGlobal | None = None,
        unknown: int | None = None,
    ) -> None:
        self.objects: list[MapObject] = []
        self.departures: list[Departure] = []
        self.frame = -1
        self._kinds, self._constants, self._draws = kinds, constants, draws
        self._handing_on, self._unknown = handing_on, unknown

    def copy(self, draws: np.random.Generator) -> LocalMap:
        """An independent copy; `draws` names its new objects."""
        other = LocalMap(self._kinds, self._constants, draws, self._handing_on, self._unknown)
        other.objects = [thing.copy() for thing in self.objects]
        other.departures = list(self.departures)
        other.frame = self.frame
        return other

    def observe(self, seen: Sequence[RunObservation]) -> None:
        """Process one keyframe. Observations are matched to the map before it; several may match one object."""
        self.frame += 1
        touched = set()
        before = len(self.objects)
        for one, match in zip(seen, matches(seen, self.objects, self._constants), strict=True):
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
        pair = together(whole, self.frame - self._constants.split_window + 1)
        if pair is not None and pair[2] > self._constants.split_frames:
            self.objects[index], other = parted(whole, pair[0], pair[1], self._uid(), self._constants)
            self.objects.append(other)

    def _advance(self, before: int) -> None:
        life = self._constants.life
        for thing in self.objects[:before]:
            missed = self.frame - thing.last_seen
            if missed <= life.window:
                thing.stage = _FRESH
            elif thing.stage.phase is not Phase.SETTLED:
                entering = thing.stage.phase is Phase.UPDATING
                thing.stage = advanced(thing.stage, missed, entering and self.stable(thing), life)
        self.objects = [thing for thing in self.objects if thing.stage.phase is not Phase.GONE]
        if self._handing_on is not None and any(thing.stage.phase is Phase.SETTLED for thing in self.objects):
            self._hand_on(self._handing_on)

    def stable(self, thing: MapObject) -> bool:
        """Whether an object is stable."""
        classes, confidences = [s.class_id for s in thing.seen], [s.confidence for s in thing.seen]
        return is_stable(classes, confidences, self._kinds, self._constants.life)

    def _hand_on(self, constants: DualmapGlobal) -> None:
        """Settled furniture departs with the objects on it; other settled objects that lie on nothing are dropped."""
        leaving: set[int] = set()
        for thing in self.objects:
            if thing.stage.phase is not Phase.SETTLED or thing.uid in leaving:
                continue
            if not thing.low_mobility:
                if not any(lies_on(thing, low, constants) for low in self.objects):
                    leaving.add(thing.uid)
                continue
            leaving.add(thing.uid)
            if thing.class_id != self._unknown:
                related = [up for up in self.objects if up.uid not in leaving and lies_on(up, thing, constants)]
                self.departures.append(Departure(thing, tuple(related)))
                leaving.update(up.uid for up in related)
        self.objects = [thing for thing in self.objects if thing.uid not in leaving]


_FRESH = Stage()


def matches(seen: Sequence[RunObservation], objects: Sequence[MapObject], constants: DualmapLocal) -> list[int | None]:
    """The index of the matching object for each observation, None for a new object.

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
            possible.append((visual + one.cloud.inside(thing.box, constants.near_m), j, visual, thing))
    best, most = None, constants.match
    for greatest, j, visual, thing in sorted(possible, key=lambda each: (-each[0], each[1])):
        if greatest < most:
            break
        similarity = visual + thing.shared(one.cloud, constants.near_m)
        if similarity > most or (similarity == most and best is not None and j < best):
            best, most = j, similarity
    return best
