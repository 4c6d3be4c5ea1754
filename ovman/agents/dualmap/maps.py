"""Stage `dualmap`: every run's maps of a scene, one of each visit and one maintained through both visits of an episode. Pure."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ovman import seeds
from ovman.agents.dualmap.mapped import Mapped, Pair, RunMaps, write
from ovman.agents.dualmap.observation_records import Walk, read_walks
from ovman.agents.dualmap.readings import Maintained, Run
from ovman.progress import Units
from ovman.records.episode import Episode, root_seed
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


def run(scene: str, walks_file: Path, episodes_file: Path, constants: Settings, output: Path) -> None:
    """Write the maps of a scene, and print their numbers of objects and the time.

    MapsError as ``check``, and for an episode's visit without a walk.
    """
    episodes = [episode for episode in Episode.load(episodes_file) if episode.scene == scene]
    walks, pairs = read_walks(walks_file), pairs_of(episodes)
    absent = sorted({visit for pair in pairs for visit in pair} - set(walks))
    if absent:
        raise MapsError(f"{walks_file} has no walk of the visit {absent[0]}; make the stage walks again")
    runs, units = [], Units(constants.dualmap.runs)
    for number in range(constants.dualmap.runs):
        began = time.process_time()
        made = run_of(number, scene, walks, pairs, root_seed(episodes), constants)
        check(scene, number, made)
        runs.append(made)
        counts = [len(mapped.entries) for mapped in (*made.visits.values(), *made.maintained.values())]
        took = time.process_time() - began
        units.done(f"{scene}: run {number}: maps of {sorted(counts)} objects in {took:.1f} s of the processor")
    write(output, runs)
