"""Runs of DualMap: one process each, in the clone, with the clone's interpreter, under a time limit.

Nothing that DualMap pickled is opened here: the process leaves plain arrays.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ovman.records.record import Count, Record
from ovman_released import dualmap_process
from ovman_released.dualmap_frames import DATASET
from ovman_released.dualmap_objects import Objects, ObjectsError, read_objects
from ovman_released.dualmap_setup import SYSTEM, Installation, environment

LOCAL, GLOBAL = "local", "global"
_SAVING = {
    LOCAL: ("run_local_mapping_only=true", "save_local_map=true", "save_global_map=false"),
    GLOBAL: ("run_local_mapping_only=false", "save_local_map=false", "save_global_map=true"),
}
"""Never both: each save empties the directory of the map, and one would be lost."""


class RunReport(Record):
    """What a run of DualMap says of itself.

    frames, keyframes: numbers of both; local_before_the_end: objects of the local map before DualMap ends; saved: number of saved
    objects by kind; seconds: duration.
    """

    frames: Count
    keyframes: Count
    local_before_the_end: Count
    saved: Mapping[str, Count]
    seconds: float


class RunError(RuntimeError):
    """A run of DualMap that gave no map; one line with the scene, the reason and where its log is."""

    def __init__(self, scene_id: str, reason: str, log: Path) -> None:
        super().__init__(f"{SYSTEM}: {scene_id}: {reason}; its log is {log}")


@dataclass(frozen=True, slots=True)
class Policy:
    """What may be chosen of a run without leaving the released code. kind: local (concrete) or global (abstract) map.

    guard: first_only or every_frame; device: cuda or cpu; seed: of every random generator, with frames taken one after the other,
    or None as released: in parallel and unseeded. time_limit_s: seconds after which a run is ended.
    """

    kind: str
    guard: str
    device: str
    time_limit_s: float
    seed: int | None = None


def overrides(policy: Policy, settings: Path, scene_id: str, output: Path, preload: Path | None = None) -> list[str]:
    """The settings of DualMap that differ from its own for one run, as on its command line.

    settings: yaml of the data set that `dualmap_frames.join` wrote; output: a new directory; preload: directory of the global map
    that the run begins with. ValueError for a local map with something to preload.
    """
    if preload is not None and policy.kind != GLOBAL:
        raise ValueError("only a global map is preloaded")
    given = [
        f"dataset_name={DATASET}",
        f"scene_id={scene_id}",
        f"dataset_path={_quoted(settings.parent)}",
        f"dataset_conf_path={_quoted(settings)}",
        f"output_path={_quoted(output)}",
        "use_stride=false",
        "use_rerun=false",
        *_SAVING[policy.kind],
    ]
    if preload is not None:
        given += ["preload_global_map=true", f"preload_path={_quoted(preload)}"]
    if policy.seed is not None:
        given.append("use_parallel=false")
    if policy.device == "cpu":  # FastSAM asks for "cuda" by name
        given += ["device=cpu", "use_fastsam=false"]
    return given


def saved_map(output: Path, scene_id: str) -> Path:
    """Where DualMap saves the objects of a run."""
    return output / f"{DATASET}_{scene_id}" / "map"


def run(
    installation: Installation,
    policy: Policy,
    settings: Path,
    scene_id: str,
    nouns: Sequence[str],
    directory: Path,
    preload: Path | None = None,
) -> Objects:
    """Runs DualMap over a sequence and gives the objects of its map.

    directory: of this run, emptied first; objects.npz, run.json, dualmap.log and DualMap's own output stay there. preload: the
    directory of a run that made a global map.

    Raises RunError for a run that fails, hangs beyond the time limit, ends without an object, or has lost an anchor that it was
    preloaded with.
    """
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir(parents=True)
    output, request, log = directory / "dualmap", directory / "request.json", directory / "dualmap.log"
    old = None if preload is None else Path(json.loads((preload / "request.json").read_text())["map"])
    request.write_text(
        json.dumps(
            {
                "overrides": overrides(policy, settings.absolute(), scene_id, output.absolute(), old),
                "guard": policy.guard,
                "nouns": list(nouns),
                "seed": policy.seed,
                "device": policy.device,
                "map": str(saved_map(output, scene_id).absolute()),
                "before": None if installation.before is None else str(installation.before.absolute()),
                "output": str(directory.absolute()),
            }
        )
    )
    _process(installation, request, log, policy, scene_id)
    try:
        objects = read_objects(directory / "objects.npz")
    except ObjectsError as error:
        raise RunError(scene_id, str(error), log) from None
    if not len(objects):
        keyframes = report(directory).keyframes
        raise RunError(scene_id, f"no object stayed in its {policy.kind} map in {keyframes} keyframes; walk more densely", log)
    if preload is not None:
        lost = set(read_objects(preload / "objects.npz").anchors) - set(objects.anchors)
        if lost:
            raise RunError(scene_id, f"{len(lost)} anchors of the preloaded map are gone, so it was not loaded", log)
    return objects


def _process(installation: Installation, request: Path, log: Path, policy: Policy, scene_id: str) -> None:
    beside = str(Path(dualmap_process.__file__).parents[1])
    command = [str(installation.python), "-m", "dualmap_process", str(request.absolute())]
    with log.open("wb") as file:
        process = subprocess.Popen(
            command,
            cwd=installation.root,
            env=environment() | {"PYTHONPATH": beside},
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=file,
            start_new_session=True,
        )
        try:
            status = process.wait(policy.time_limit_s)
        except subprocess.TimeoutExpired:
            raise RunError(scene_id, f"ended after {policy.time_limit_s:g} s without a map", log) from None
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    if status:
        raise RunError(scene_id, _said(request.with_name("error.txt")) or f"ended with status {status}", log)


def _said(path: Path) -> str:
    return path.read_text(errors="replace").strip() if path.is_file() else ""


def _quoted(path: Path) -> str:
    """A path as Hydra's grammar has a string."""
    return "'" + str(path).replace("\\", "\\\\").replace("'", "\\'") + "'"


def report(directory: Path) -> RunReport:
    """What the finished run in a directory says of itself. RecordError for a file that is no report."""
    path = directory / "run.json"
    return RunReport.parse(path.read_text(), str(path))
