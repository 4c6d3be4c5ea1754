"""Stage `dualmap`: every run's maps of a scene, one of each visit and one maintained through both visits of an episode. Pure."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ovman.agents.dualmap.mapped import Mapped, Pair, RunMaps, write
from ovman.agents.dualmap.observation_records import Walk, read_walks
from ovman.agents.dualmap.readings import Maintained, Run
from ovman.models.record import read_records
from ovman.models.settings import Settings
from ovman.workflow import seeds


class MapsError(RuntimeError):
    """A scene whose maps cannot be made; one line that names the scene, the visit and the remedy."""

    says_all = True


def pairs_of(scene: str, episodes: Path, trials: Path) -> list[Pair]:
    """The names of both visits of the scene's released episodes, each pair once."""
    released = {episode["id"] for episode in read_records(episodes) if episode["scene"] == scene}
    visits = [t["measured"]["visits"] for t in read_records(trials) if t["candidate"]["id"] in released]
    return list(dict.fromkeys((visit["first"], visit["second"]) for visit in visits))


def run_of(number: int, scene: str, walks: Mapping[str, Walk], pairs: Sequence[Pair], constants: Settings) -> RunMaps:
    """The maps of a scene that the run of that number makes. constants own benchmark.seed and what it needs of `dualmap`."""

    def draws(*visits: str) -> Any:
        return seeds.generator(constants.benchmark.seed, "dualmap", scene, *visits, number)

    kinds, unknown = next(((walk.kinds, walk.unknown) for walk in walks.values()), (0, None))
    run = Run(number, kinds, constants.dualmap, draws, unknown)
    keyframes = {name: walk.frames for name, walk in walks.items()}
    return run.read(Maintained(constants.dualmap.maintained), keyframes, pairs)


def check(scene: str, run: int, made: RunMaps) -> None:
    """MapsError for a map of no object, which would answer nothing and look like a poor system."""
    named: dict[str, Mapped] = {**made.visits, **{" and ".join(pair): mapped for pair, mapped in made.maintained.items()}}
    for name, mapped in named.items():
        if not mapped.entries:
            raise MapsError(
                f"{scene}: run {run}: the map of {name} has no object after {mapped.frames} keyframes; no object was seen in "
                "enough of them: make the walks denser (dualmap.walk in config.yaml)"
            )


def run(scene: str, walks_file: Path, episodes: Path, trials: Path, constants: Settings, output: Path) -> None:
    """Write the maps of a scene, and print how many objects they hold and what they took.

    MapsError as ``check``, and for an episode's visit that was not walked.
    """
    walks, pairs = read_walks(walks_file), pairs_of(scene, episodes, trials)
    absent = sorted({visit for pair in pairs for visit in pair} - set(walks))
    if absent:
        raise MapsError(f"{walks_file} has no walk of the visit {absent[0]}; make the stage walks again")
    runs = []
    for number in range(constants.dualmap.runs):
        began = time.process_time()
        made = run_of(number, scene, walks, pairs, constants)
        check(scene, number, made)
        runs.append(made)
        counts = [len(mapped.entries) for mapped in (*made.visits.values(), *made.maintained.values())]
        took = time.process_time() - began
        print(f"{scene}: run {number}: maps of {sorted(counts)} objects in {took:.1f} s of the processor", flush=True)
    write(output, runs)
