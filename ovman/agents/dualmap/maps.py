"""Stage `dualmap`: every run's maps of a scene, one of each visit and one maintained through both visits of an episode.

A maintained map is the local map, run over the first visit's keyframes and then the second's. It keeps former places, because
DualMap never deletes or moves a settled object. Runs differ as DualMap's do: in the pixels of a mask that make its cloud, and
in the order of saved objects, which is that of random names. DualMap's mapper can also drop keyframes when it falls behind the
camera; here it processes all of them.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ovman import seeds
from ovman.agents.dualmap import DualmapLocal
from ovman.agents.dualmap.cloud import Cloud
from ovman.agents.dualmap.local_map import LocalMap, Sight
from ovman.agents.dualmap.mapped import OBJECT, Mapped, Pair, RunMaps, write
from ovman.agents.dualmap.observations import FrameObject, Walks, read_walks
from ovman.processes import Units, map_items
from ovman.records.episode import Episode, root_seed
from ovman.settings import Settings


class MapsError(RuntimeError):
    """A scene whose maps cannot be made; one line that names the scene, the visit and the remedy."""

    says_all = True


def run(episodes_file: Path, walks: Path, settings: Settings, output: Path, workers: int = 1) -> None:
    """Write the maps of the episodes' scenes, one file per scene, in so many processes. walks: observations on dense tours.

    Raises MapsError as `map_run`, and if a visit of an episode has no dense tour.
    """
    scenes = list(dict.fromkeys(episode.scene for episode in Episode.load(episodes_file)))
    output.mkdir(parents=True, exist_ok=True)
    map_items(partial(_write_scene, episodes_file, walks, settings, output), scenes, workers)


def _write_scene(episodes_file: Path, walks: Path, settings: Settings, output: Path, scene: str) -> None:
    episodes = Episode.load(episodes_file, scene)
    file = walks / f"{scene}.npz"
    found, pairs = read_walks(file), find_pairs(episodes)
    absent = sorted({visit for pair in pairs for visit in pair} - set(found.keyframes))
    if absent:
        raise MapsError(f"{file} has no walk of the visit {absent[0]}; make the stage walks again")
    runs, units = [], Units(settings.dualmap.runs)
    for number in range(settings.dualmap.runs):
        began = time.process_time()
        maps = map_run(number, scene, found, pairs, root_seed(episodes), settings.dualmap.local_map)
        runs.append(maps)
        counts = [len(mapped) for mapped in (*maps.visits.values(), *maps.maintained.values())]
        took = time.process_time() - began
        units.done(f"{scene}: run {number}: maps of {sorted(counts)} objects in {took:.1f} s of the processor")
    write(output / f"{scene}.npz", runs)


def find_pairs(episodes: Sequence[Episode]) -> list[Pair]:
    """Return the names of both visits of a scene's episodes, each pair once."""
    return list(dict.fromkeys((episode.visits.first, episode.visits.second) for episode in episodes))


def map_run(number: int, scene: str, walks: Walks, pairs: Sequence[Pair], seed: int, constants: DualmapLocal) -> RunMaps:
    """Return the maps of a scene's visits and of pairs of them. number: of the run; seed: root of its draws.

    Raises MapsError for a map without objects, which would pass for a system that fails.
    """
    sights: dict[int, Sight] = {}

    def observe(local: LocalMap, visit: str) -> None:
        for frame in walks.keyframes[visit]:
            for one in frame:
                if id(one) not in sights:  # dense tours share frames
                    sights[id(one)] = sight_of(one, number)
            local.observe([sights[id(one)] for one in frame])

    def draws(*visits: str) -> np.random.Generator:
        return seeds.generator(seed, "dualmap", scene, *visits, number)

    def save(local: LocalMap, *visits: str) -> Mapped:
        things = local.finish()
        if not things:
            raise MapsError(
                f"{scene}: run {number}: the map of {' and '.join(visits)} has no object after {local.keyframes} keyframes; no "
                "object was seen in enough of them: make the walks denser (section dualmap.walk of the settings)"
            )
        return Mapped(
            local.keyframes,
            position=np.array([thing.position for thing in things]),
            feature=np.array([thing.feature for thing in things]),
            sort=np.full(len(things), OBJECT),
            class_id=np.array([thing.class_id for thing in things]),
            first_seen=np.array([thing.seen[0].keyframe for thing in things]),
            last_seen=np.array([thing.last_seen for thing in things]),
            members=tuple(np.array([observed.number for observed in thing.seen]) for thing in things),
        )

    locals_ = {visit: LocalMap(walks.kinds, constants, draws(visit)) for visit in walks.keyframes}
    for visit, local in locals_.items():
        observe(local, visit)
    visits = {visit: save(local, visit) for visit, local in locals_.items()}
    maintained = {}
    for first, second in pairs:
        local = locals_[first].copy(draws(first, second))
        observe(local, second)
        maintained[first, second] = save(local, first, second)
    return RunMaps(visits, maintained)


def sight_of(one: FrameObject, run: int) -> Sight:
    """Return what a run has of an object in a frame."""
    return Sight(one.class_id, one.confidence, np.asarray(one.feature, np.float64), Cloud.of(one.clouds[run]))
