"""The stage "dualmap_objects": how many objects DualMap's maps hold, of how many keyframes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

from ovman.agents.dualmap.mapped import Mapped, RunMaps, read
from ovman.analysis import frames

VISIT, MAINTAINED, ALL = "two visits", "maintained map", "all"


@dataclass(frozen=True, slots=True)
class Objects:
    """The maps of one run (or ALL) in one scene (or ALL), of single visits or maintained through two.

    frames: keyframes, the mean over the maps; objects_mean, objects_min, objects_max: objects that a map holds.
    """

    scene: str
    memory: str
    run: int | str
    maps: int
    frames: float
    objects_mean: float
    objects_min: int
    objects_max: int

    @staticmethod
    def of(scene: str, memory: str, run: int | str, maps: Sequence[Mapped]) -> Objects:
        """Of at least one map."""
        counts = [len(mapped.entries) for mapped in maps]
        frames = fmean(mapped.frames for mapped in maps)
        return Objects(scene, memory, run, len(maps), frames, fmean(counts), min(counts), max(counts))


def counted(scenes: Iterable[tuple[str, Sequence[RunMaps]]]) -> list[Objects]:
    """A row for all scenes and runs, then one for each scene and run. A scene without visits has none."""
    rows: list[Objects] = []
    every: dict[str, list[Mapped]] = {VISIT: [], MAINTAINED: []}
    for scene, runs in scenes:
        for number, run in enumerate(runs):
            for memory, maps in ((VISIT, list(run.visits.values())), (MAINTAINED, list(run.maintained.values()))):
                if maps:
                    rows.append(Objects.of(scene, memory, number, maps))
                    every[memory] += maps
    return [Objects.of(ALL, memory, ALL, maps) for memory, maps in every.items() if maps] + rows


def run(files: Sequence[Path], output: Path) -> None:
    """Write the rows of `counted`. files: of the stage "dualmap", named after the scenes."""
    rows = counted((path.stem, read(path)) for path in files)
    frames.write(output, Objects, rows)
    for row in (row for row in rows if row.scene == ALL):
        counts = f"{row.objects_min} to {row.objects_max} objects, {row.objects_mean:.1f} on average"
        print(f"{row.memory}: {row.maps} maps of {counts}", flush=True)
