"""Stage `released_dualmap`: DualMap as its authors released it, on dense walks of a scene's visits. Its maps are those of ours.

A visit is mapped by itself; the two visits of an episode are mapped once more, as one map that is maintained through both. Every
run is a process of its own. Finished runs are kept, so that a killed job goes on with the next one.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.dualmap.mapped import Mapped, Pair, RunMaps, write
from ovman.agents.dualmap.walks import Assigned, embodiment, walk_frames
from ovman.cache import digest
from ovman.perception.records import write_nouns
from ovman.settings import Settings
from ovman.sim.session import Session
from ovman_released import dualmap_runner
from ovman_released.dualmap_frames import join, write_visit
from ovman_released.dualmap_objects import Objects, read_objects
from ovman_released.dualmap_runner import GLOBAL, LOCAL, Policy
from ovman_released.dualmap_setup import Installation
from ovman_released.plugin import DUALMAP
from ovman_released.settings import released_dualmap

NOT_OF_A_RUN = ("dualmap.runs", f"{DUALMAP}.root", f"{DUALMAP}.python", f"{DUALMAP}.time_limit_s")
"""Constants that say where things are, how many runs there are or how long they may take, not what a run gives."""
_DONE = "done"


class Maintained(StrEnum):
    """Which map is maintained through two visits, and how; the maps of single visits are of the same kind.

    CONCATENATED_LOCAL, CONCATENATED_GLOBAL: one run over the first visit's frames and then the second's. PRELOADED_GLOBAL: a run
    over the first visit, and one over the second that begins with the anchors of the first.
    """

    CONCATENATED_LOCAL = "concatenated_local"
    CONCATENATED_GLOBAL = "concatenated_global"
    PRELOADED_GLOBAL = "preloaded_global"

    @property
    def kind(self) -> str:
        """Whose objects are saved: the local map's or the global one's."""
        return LOCAL if self is Maintained.CONCATENATED_LOCAL else GLOBAL


@dataclass(frozen=True, eq=False)
class Runs:
    """The runs of a scene. walk: writes the frames of the visit of a name into a directory; kept: where finished runs are.

    identity: what a visit and its walk are, by name, JSON-serialisable; a run is found again by those of its visits. One job at a
    time has `kept`.
    """

    installation: Installation
    policy: Policy
    maintained: Maintained
    scene: str
    nouns: Sequence[str]
    identity: Mapping[str, Any]
    walk: Callable[[str, Path], object]
    kept: Path

    @cached_property
    def _frames(self) -> Path:
        self.kept.mkdir(parents=True, exist_ok=True)
        for left in self.kept.glob("frames.*"):
            shutil.rmtree(left)
        return Path(tempfile.mkdtemp(prefix="frames.", dir=self.kept))

    def clear(self) -> None:
        """Removes the frames: they are hundreds of megabytes, and are made again where they are asked for."""
        if "_frames" in self.__dict__:
            shutil.rmtree(self._frames, ignore_errors=True)

    def run(self, number: int, visits: Sequence[str]) -> tuple[Objects, int]:
        """The objects of the run of that number over one visit, or maintained through two, and in how many keyframes."""
        key = digest([self.identity[name] for name in visits], number)
        directory = self.kept / key
        if not (directory / _DONE).exists():
            last = self._made(directory, visits)
            for name in ("objects.npz", "run.json", "dualmap.log"):
                if last != directory:
                    shutil.copyfile(last / name, directory / name)
            for left in directory.iterdir():
                if left.is_dir():
                    shutil.rmtree(left)
            (directory / _DONE).touch()
            said = dualmap_runner.report(directory)
            print(
                f"{self.scene}: run {number}: {' and '.join(visits)}: {said.frames} frames, {said.keyframes} keyframes, "
                f"{said.local_before_the_end} objects before the end, saved {dict(said.saved)}, {said.seconds:.0f} s",
                flush=True,
            )
        return read_objects(directory / "objects.npz"), dualmap_runner.report(directory).keyframes

    def _made(self, directory: Path, visits: Sequence[str]) -> Path:
        """Runs DualMap over `visits`; the directory of its last process."""
        shutil.rmtree(directory, ignore_errors=True)
        if len(visits) == 1 or self.maintained is not Maintained.PRELOADED_GLOBAL:
            self._process(directory, visits)
            return directory
        first, second = (directory / name for name in ("first", "second"))
        self._process(first, visits[:1])
        self._process(second, visits[1:], first)
        return second

    def _process(self, directory: Path, visits: Sequence[str], preload: Path | None = None) -> None:
        places = [self._visit(name) for name in visits]
        with tempfile.TemporaryDirectory(prefix="sequence.", dir=self._frames) as joined:
            settings = join(places, Path(joined), self.scene)
            dualmap_runner.run(self.installation, self.policy, settings, self.scene, self.nouns, directory, preload)

    def _visit(self, name: str) -> Path:
        directory = self._frames / digest(name)
        if not directory.exists():
            self.walk(name, directory)
        return directory

    def maps(self, number: int, visits: Sequence[str], pairs: Sequence[Pair]) -> tuple[RunMaps, Mapping[str, np.ndarray]]:
        """All maps of the run of that number, and what DualMap makes of the nouns."""
        nouns: dict[str, np.ndarray] = {}

        def mapped(names: Sequence[str]) -> Mapped:
            found, keyframes = self.run(number, names)
            nouns.update(found.nouns)
            return found.mapped(keyframes)

        return RunMaps({name: mapped([name]) for name in visits}, {pair: mapped(pair) for pair in pairs}), nouns


def policy_of(constants: Settings) -> Policy:
    """How DualMap is run: as released, but for what the section `released_dualmap` says."""
    chosen = released_dualmap(constants)
    return Policy(Maintained(chosen.maintained).kind, chosen.guard, chosen.device, chosen.time_limit_s)


def identity(of: Mapping[str, Assigned], nouns: Sequence[str], constants: Settings) -> dict[str, Any]:
    """Return what decides a run over a visit, wherever the clone lies: the visit, the nouns and the constants."""
    values = constants.constants()
    overrides = dualmap_runner.overrides(policy_of(constants), Path("settings"), "scene", Path("output"))
    asked = digest({k: v for k, v in values.items() if k not in NOT_OF_A_RUN}, list(nouns), overrides)
    return {name: [asked, *_walk_of(one)] for name, one in of.items()}


def _walk_of(one: Assigned) -> list[Any]:
    """What the walk of a visit depends on beside the size of its frames, JSON-serialisable."""
    episode, record = one.episode, one.recorded.to_json()
    protocol = [dict(getattr(episode.protocol, name)) for name in ("camera", "primitives", "mover")]
    visited = [record[key] for key in ("scene", "alterations", "movers", "views")]
    return [episode.backend, episode.provenance.seed, episode.id, protocol, *visited]


def run(
    scene: str,
    of: Mapping[str, Assigned],
    pairs: Sequence[Pair],
    floor_y: float,
    nouns: Sequence[str],
    constants: Settings,
    kept: Path,
    maps: Path,
    text: Path,
) -> None:
    """Writes the maps of a scene's visits `of` (name -> what to walk) and of the `pairs` of them, and to `text` the nouns.

    floor_y: height of the scene's floor, metres; kept: directory of finished runs. Raises RunError in one
    line where a run fails or a map stays empty, WalkError, SimulatorError, ValueError for a scene without episodes.
    """
    chosen = released_dualmap(constants)
    maintained = Maintained(chosen.maintained)
    installation = Installation(Path(chosen.root).absolute(), Path(chosen.python))
    policy, turn_deg = policy_of(constants), constants.dualmap.walk.turn_deg
    if not of:
        raise ValueError(f"{scene}: no episode is in this scene; take it out of splits.main.scenes")
    benchmark = next(iter(of.values())).episode.settings
    with Session(scene, benchmark, embodiment(benchmark, chosen.side_px)) as session:

        def walked(name: str, directory: Path) -> None:
            lens = session.with_restarts(lambda: write_visit(directory, walk_frames(session, of[name], turn_deg), floor_y))
            print(f"{scene}: {name}: {lens.frames} frames of {lens.width} x {lens.height} px", flush=True)

        runs = Runs(installation, policy, maintained, scene, nouns, identity(of, nouns, constants), walked, kept)
        try:
            made = [runs.maps(number, list(of), pairs) for number in range(constants.dualmap.runs)]
        finally:
            runs.clear()
    write(maps, [one for one, _ in made])
    write_nouns(text, {phrase: made[0][1][phrase] for phrase in nouns})
