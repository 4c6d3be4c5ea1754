"""The two readings of DualMap over two visits: a map of each, and one map that was maintained through both.

CONCATENATED_LOCAL: the local map, run over the first visit's keyframes and then the second's. PRELOADED_GLOBAL: the global map
of the second visit, which begins with the anchors of the first. Both keep former places, because DualMap never deletes or moves a
settled object. Runs differ as DualMap's do: in the pixels of a mask that make its cloud, and in the order of saved objects, which
is that of random names. DualMap's mapper can also drop keyframes when it falls behind the camera; here it processes all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ovman.agents.dualmap.cloud import Cloud
from ovman.agents.dualmap.global_map import Anchor, GlobalMap
from ovman.agents.dualmap.local_map import Departure, LocalMap
from ovman.agents.dualmap.map_object import RunObservation
from ovman.agents.dualmap.mapped import Entry, Mapped, Pair, RunMaps
from ovman.agents.dualmap.observation import ObjectObservation
from ovman.agents.dualmap.settings import Dualmap

Keyframes = Sequence[Sequence[ObjectObservation]]
Looks = Sequence[Sequence[RunObservation]]
"""Keyframes of one run."""
Draws = Callable[..., np.random.Generator]
"""From names of visits to the generator of the objects' names."""


class Maintained(StrEnum):
    """The kind of the maintained map and of the maps of single visits."""

    CONCATENATED_LOCAL = "concatenated_local"
    PRELOADED_GLOBAL = "preloaded_global"


@dataclass(frozen=True, slots=True)
class Run:
    """One run of DualMap.

    number: index of the run's clouds in every observation; kinds: number of classes; unknown: the class of what no name fits,
    which becomes no anchor, or None; constants: owns local_map and global_map; draws: as `Draws`.
    """

    number: int
    kinds: int
    constants: Dualmap
    draws: Draws
    unknown: int | None = None

    def read(self, maintained: Maintained, walks: Mapping[str, Keyframes], pairs: Iterable[Pair]) -> RunMaps:
        """The maps of the visits in `walks`, by name, and of the given pairs of visits."""
        pairs = list(dict.fromkeys(pairs))
        seen = self._looks(walks)
        if maintained is Maintained.CONCATENATED_LOCAL:
            return self._concatenated_local(seen, pairs)
        return self._preloaded_global(seen, pairs)

    def _looks(self, walks: Mapping[str, Keyframes]) -> dict[str, Looks]:
        """The keyframes of this run. Walks share frames and therefore clouds."""
        clouds: dict[int, Cloud] = {}

        def seen(one: ObjectObservation) -> RunObservation:
            points = one.clouds[self.number]
            if id(points) not in clouds:
                clouds[id(points)] = Cloud.of(points)
            return RunObservation.of(one, self.number, clouds[id(points)])

        return {name: [[seen(one) for one in frame] for frame in keyframes] for name, keyframes in walks.items()}

    def _concatenated_local(self, walks: Mapping[str, Looks], pairs: Sequence[Pair]) -> RunMaps:
        visits, kept = {}, {}
        firsts = {first for first, _ in pairs}
        for name, keyframes in walks.items():
            now = self._seen(self._local(self.draws(name), handing_on=False), keyframes)
            if name in firsts:
                kept[name] = now.copy(self.draws(name))
            visits[name] = _settled(now, len(keyframes))
        maintained = {}
        for first, second in pairs:
            now = self._seen(kept[first].copy(self.draws(first, second)), walks[second])
            maintained[first, second] = _settled(now, len(walks[second]), walks[first])
        return RunMaps(visits, maintained)

    def _preloaded_global(self, walks: Mapping[str, Looks], pairs: Sequence[Pair]) -> RunMaps:
        departures, anchors = {}, {}
        for name, keyframes in walks.items():
            local = self._seen(self._local(self.draws(name), handing_on=True), keyframes)
            local.flush()
            departures[name] = local.departures
            anchors[name] = self._anchors(local.departures)
        visits = {name: _saved(anchors[name], len(keyframes)) for name, keyframes in walks.items()}
        maintained = {
            (first, second): _saved(
                self._anchors(departures[second], anchors[first], _count(walks[first])), len(walks[first]) + len(walks[second])
            )
            for first, second in pairs
        }
        return RunMaps(visits, maintained)

    def _local(self, draws: np.random.Generator, handing_on: bool) -> LocalMap:
        constants = self.constants
        return LocalMap(self.kinds, constants.local_map, draws, constants.global_map if handing_on else None, self.unknown)

    def _seen(self, local: LocalMap, keyframes: Looks) -> LocalMap:
        for seen in keyframes:
            local.observe(seen)
        return local

    def _anchors(self, departures: Sequence[Departure], preloaded: Sequence[Anchor] = (), before: int = 0) -> list[Anchor]:
        """The anchors of a visit, with the preloaded ones of `before` observations, in the order in which they are saved."""
        found = GlobalMap(self.constants.local_map.voxel_m, self.constants.global_map, preloaded)
        found.take(departures, before)
        return sorted(found.anchors, key=lambda anchor: anchor.uid)


def _settled(local: LocalMap, frames: int, first: Looks = ()) -> Mapped:
    """A flushed local map as it is saved, `frames` keyframes after those of a first walk."""
    local.flush()
    things, before = sorted(local.objects, key=lambda thing: thing.uid), _count(first)
    return Mapped(tuple(Entry.of_object(thing, len(first), before) for thing in things), len(first) + frames)


def _count(keyframes: Looks) -> int:
    """Number of observations."""
    return sum(map(len, keyframes))


def _saved(anchors: Sequence[Anchor], frames: int) -> Mapped:
    return Mapped(tuple(entry for anchor in anchors for entry in Entry.of_anchor(anchor)), frames)
