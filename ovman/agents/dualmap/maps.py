"""Stage `dualmap`: every run's maps of a scene, one of each visit and one maintained through both visits of an episode. Pure."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ovman import seeds
from ovman.agents.dualmap.mapped import Mapped, Pair, RunMaps, write
from ovman.agents.dualmap.observation_records import Walk, read_walks
from ovman.agents.dualmap.readings import Maintained, Run
from ovman.processes import map_items
from ovman.progress import Units
from ovman.records.episode import Episode, root_seed
from ovman.records.record import lines
from ovman.settings import Settings


class MapsError(RuntimeError):
    """A scene whose maps cannot be made; one line that names the scene, the visit and the remedy."""

    says_all = True


def pairs_of(episodes: Sequence[Episode]) -> list[Pair]:
    """The names of both visits of a scene's episodes, each pair once."""
    return list(dict.fromkeys((episode.visits.first, episode.visits.second) for episode in episodes))


def run_of(number: int, scene: str, walks: Mapping[str, Walk], pairs: Sequence[Pair], seed: int, constants: Settings) -> RunMaps:
    """The maps of a scene of the run `number`. seed: root of its draws; constants: those of section `dualmap`."""

    def draws(*visits: str) -> np.random.Generator:
        return seeds.generator(seed, "dualmap", scene, *visits, number)

    kinds, unknown = next(((walk.kinds, walk.unknown) for walk in walks.values()), (0, None))
    run = Run(number, kinds, constants.dualmap, draws, unknown)
    keyframes = {name: walk.frames for name, walk in walks.items()}
    return run.read(Maintained(constants.dualmap.maintained), keyframes, pairs)


def check(scene: str, run: int, made: RunMaps) -> None:
    """MapsError for a map without objects, which would pass for a system that fails."""
    named: dict[str, Mapped] = {**made.visits, **{" and ".join(pair): mapped for pair, mapped in made.maintained.items()}}
    for name, mapped in named.items():
        if not mapped.entries:
            raise MapsError(
                f"{scene}: run {run}: the map of {name} has no object after {mapped.frames} keyframes; no object was seen in "
                "enough of them: make the walks denser (dualmap.walk in config.yaml)"
            )


def run(episodes_file: Path, walks: Path, settings: Settings, output: Path, workers: int = 1) -> None:
    """Write the maps of the episodes' scenes, one file per scene.

    Args:
        episodes_file: The episodes.
        walks: Folder of the observations on dense tours.
        settings: Section `dualmap`.
        output: Folder of the maps.
        workers: Number of processes over the scenes.

    Raises:
        MapsError: As `check`, and if a visit of an episode has no dense tour.
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
    found, pairs = read_walks(file), pairs_of(episodes)
    absent = sorted({visit for pair in pairs for visit in pair} - set(found))
    if absent:
        raise MapsError(f"{file} has no walk of the visit {absent[0]}; make the stage walks again")
    runs, units = [], Units(settings.dualmap.runs)
    for number in range(settings.dualmap.runs):
        began = time.process_time()
        made = run_of(number, scene, found, pairs, root_seed(episodes), settings)
        check(scene, number, made)
        runs.append(made)
        counts = [len(mapped.entries) for mapped in (*made.visits.values(), *made.maintained.values())]
        took = time.process_time() - began
        units.done(f"{scene}: run {number}: maps of {sorted(counts)} objects in {took:.1f} s of the processor")
    write(output / f"{scene}.npz", runs)
