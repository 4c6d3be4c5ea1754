"""Stage `dualmap`: every run's maps of a scene, one of each visit and one maintained through both visits of an episode.

A maintained map is the local map, run over the first visit's keyframes and then the second's. It keeps former places, because
DualMap never deletes or moves a settled object. Runs differ as DualMap's do: in the pixels of a mask that make its cloud, and
in the order of saved objects, which is that of random names. DualMap's mapper can also drop keyframes when it falls behind the
camera; here it processes all of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ovman import seeds
from ovman.agents.dualmap.cloud import Cloud
from ovman.agents.dualmap.local_map import LocalMap, RunObservation
from ovman.agents.dualmap.mapped import Entry, Mapped, Pair, RunMaps, write
from ovman.agents.dualmap.observations import ObjectObservation, Walk, read_walks
from ovman.agents.dualmap.settings import DualmapLocal
from ovman.processes import map_items
from ovman.progress import Units
from ovman.records.episode import Episode, root_seed
from ovman.records.record import lines
from ovman.settings import Settings

Keyframes = Sequence[Sequence[ObjectObservation]]
Looks = Sequence[Sequence[RunObservation]]
"""Keyframes of one run."""


class MapsError(RuntimeError):
    """A scene whose maps cannot be made; one line that names the scene, the visit and the remedy."""

    says_all = True


def run(episodes_file: Path, walks: Path, settings: Settings, output: Path, workers: int = 1) -> None:
    """Write the maps of the episodes' scenes, one file per scene.

    Args:
        episodes_file: The episodes.
        walks: Folder of the observations on dense tours.
        settings: Section `dualmap`.
        output: Folder of the maps.
        workers: Number of processes over the scenes.

    Raises:
        MapsError: As `check_maps`, and if a visit of an episode has no dense tour.
    """
    by_scene: dict[str, list[Episode]] = {}
    for episode in Episode.load(episodes_file):
        by_scene.setdefault(episode.scene, []).append(episode)
    output.mkdir(parents=True, exist_ok=True)
    write_one = partial(_write_scene, walks=walks, settings=settings, output=output)
    map_items(write_one, [lines(episodes) for episodes in by_scene.values()], workers)


def _write_scene(episode_lines: str, walks: Path, settings: Settings, output: Path) -> None:
    episodes = [Episode.parse(line) for line in episode_lines.splitlines()]
    scene = episodes[0].scene
    file = walks / f"{scene}.npz"
    found, pairs = read_walks(file), find_pairs(episodes)
    absent = sorted({visit for pair in pairs for visit in pair} - set(found))
    if absent:
        raise MapsError(f"{file} has no walk of the visit {absent[0]}; make the stage walks again")
    runs, units = [], Units(settings.dualmap.runs)
    for number in range(settings.dualmap.runs):
        began = time.process_time()
        maps = map_run(number, scene, found, pairs, root_seed(episodes), settings)
        check_maps(scene, number, maps)
        runs.append(maps)
        counts = [len(mapped.entries) for mapped in (*maps.visits.values(), *maps.maintained.values())]
        took = time.process_time() - began
        units.done(f"{scene}: run {number}: maps of {sorted(counts)} objects in {took:.1f} s of the processor")
    write(output / f"{scene}.npz", runs)


def find_pairs(episodes: Sequence[Episode]) -> list[Pair]:
    """Return the names of both visits of a scene's episodes, each pair once."""
    return list(dict.fromkeys((episode.visits.first, episode.visits.second) for episode in episodes))


def map_run(number: int, scene: str, walks: Mapping[str, Walk], pairs: Sequence[Pair], seed: int, settings: Settings) -> RunMaps:
    """Return the maps of a scene of the run `number`. seed: root of its draws; settings: section `dualmap`."""

    def draws(*visits: str) -> np.random.Generator:
        return seeds.generator(seed, "dualmap", scene, *visits, number)

    kinds = next((len(walk.names) for walk in walks.values()), 0)
    keyframes = {name: walk.frames for name, walk in walks.items()}
    return Run(number, kinds, settings.dualmap.local_map, draws).map_visits(keyframes, pairs)


def check_maps(scene: str, run: int, maps: RunMaps) -> None:
    """Raise MapsError for a map without objects, which would pass for a system that fails."""
    named: dict[str, Mapped] = {**maps.visits, **{" and ".join(pair): mapped for pair, mapped in maps.maintained.items()}}
    for name, mapped in named.items():
        if not mapped.entries:
            raise MapsError(
                f"{scene}: run {run}: the map of {name} has no object after {mapped.frames} keyframes; no object was seen in "
                "enough of them: make the walks denser (section dualmap.walk of the settings)"
            )


@dataclass(frozen=True, slots=True)
class Run:
    """One run of DualMap.

    Attributes:
        number: Index of the run's clouds in every observation.
        kinds: Number of classes.
        constants: Section dualmap.local_map.
        draws: From names of visits to the generator of the objects' names.
    """

    number: int
    kinds: int
    constants: DualmapLocal
    draws: Callable[..., np.random.Generator]

    def map_visits(self, walks: Mapping[str, Keyframes], pairs: Iterable[Pair]) -> RunMaps:
        """Return the maps of the visits in `walks`, by name, and of the given pairs of visits."""
        seen = self._select_clouds(walks)
        pairs = list(dict.fromkeys(pairs))
        visits, kept = {}, {}
        firsts = {first for first, _ in pairs}
        for name, keyframes in seen.items():
            local = LocalMap(self.kinds, self.constants, self.draws(name))
            _observe(local, keyframes)
            if name in firsts:
                kept[name] = local.copy(self.draws(name))
            visits[name] = _settle(local, len(keyframes))
        maintained = {}
        for first, second in pairs:
            local = kept[first].copy(self.draws(first, second))
            _observe(local, seen[second])
            maintained[first, second] = _settle(local, len(seen[second]), seen[first])
        return RunMaps(visits, maintained)

    def _select_clouds(self, walks: Mapping[str, Keyframes]) -> dict[str, Looks]:
        """Return the keyframes of this run. Dense tours share frames and therefore clouds."""
        clouds: dict[int, Cloud] = {}

        def select(one: ObjectObservation) -> RunObservation:
            points = one.clouds[self.number]
            if id(points) not in clouds:
                clouds[id(points)] = Cloud.of(points)
            return RunObservation.of(one, self.number, clouds[id(points)])

        return {name: [[select(one) for one in frame] for frame in keyframes] for name, keyframes in walks.items()}


def _observe(local: LocalMap, keyframes: Looks) -> None:
    for seen in keyframes:
        local.observe(seen)


def _settle(local: LocalMap, frames: int, first: Looks = ()) -> Mapped:
    """Return the flushed local map as it is saved, `frames` keyframes after those of a first dense tour."""
    local.flush()
    before = sum(map(len, first))
    things = sorted(local.objects, key=lambda thing: thing.uid)
    return Mapped(tuple(Entry.of_object(thing, len(first), before) for thing in things), len(first) + frames)
