"""A small piece of OVMAN's real work on one scene, for `ovman record` and `ovman replay`.

The stages' own functions do it: the survey of the scene, then a displaced, a removed and a moving instance as trials (both tours,
the measurements around the answer, the look-down sweep), and the oracle's episode on each.
"""

from __future__ import annotations

import platform
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ovman import __version__, seeds
from ovman.generation.candidates import draw_candidates
from ovman.generation.certification import oracle_run
from ovman.generation.drawing import Drawing
from ovman.generation.scenes import survey
from ovman.generation.trials import Trials
from ovman.sim import controller
from ovman.sim.embodiment import Embodiment
from ovman.sim.recording.comparison import RULES, Summary, summaries
from ovman.sim.recording.file import Header, Recording, RecordingError, Result, Writer, read
from ovman.sim.recording.live import replayed
from ovman.sim.recording.playback import Playback
from ovman.sim.recording.recorder import Recorder, plain
from ovman.sim.session import Session
from ovman.task import Relation
from ovman.workflow.parameter import StageSettings

STAGES = ("scenes", "candidates", "trials", "certified")
"""The stages whose constants the work uses."""
WORK = (Relation.MOVED, Relation.REMOVED, Relation.MOVING)
NAME_LIMIT_S = 30.0


def work(scene: str, views: Mapping[str, StageSettings], start: controller.Start) -> Iterator[Result]:
    """The results of the work. `start` returns the Controller; visits are written to a temporary directory."""
    with tempfile.TemporaryDirectory() as visits, Session(scene, views["scenes"], start=start) as session:
        found = survey(session, views["scenes"].tour.waypoints, views["scenes"].primitives.step_m)
        yield Result("survey", found.to_json())
        constants = views["candidates"]
        drawing = Drawing.of(constants.splits["main"], found, constants)
        drawn = [c for c in draw_candidates(found, drawing, constants) if c.refused is None]
        first = {relation: next((c for c in drawn if c.relation is relation), None) for relation in WORK}
        trials = Trials(session, found, views["trials"], Path(visits))
        for relation, candidate in first.items():
            if candidate is None:
                continue
            trial = trials.measure(candidate)
            yield Result(f"{relation.value} trial", trial.to_json())
            if trial.measured.ended is None:
                certified = views["certified"]
                seed = seeds.integer(certified.benchmark.seed, "certification", candidate.id, 0)
                yield Result(f"{relation.value} oracle", {"seed": seed} | oracle_run(session, trial, seed, certified).to_json())


def record(scene: str, views: Mapping[str, StageSettings], output: Path) -> Recording:
    """Do the work on the backend of `views`, record it in `output`, and read the recording back."""
    header = Header(
        views["scenes"].benchmark.backend,
        scene,
        asdict(Embodiment.of(views["scenes"])),
        {stage: views[stage].canonical for stage in STAGES},
        _versions(),
        _platform(),
    )
    with Writer(output, header) as writer:
        for result in work(scene, views, Recorder.start(writer)):
            writer.write(Result(result.work, plain(result.record)))
    return read(output)


def rehearsed(recording: Recording) -> list[str]:
    """Repeat the work on the recorded answers: names of the results that differ from the recorded ones.

    RecordingError if the work calls the simulator differently than when it was recorded.
    """
    playback = Playback(recording)
    views = {stage: StageSettings.parse(text) for stage, text in recording.header.constants.items()}
    again = {result.work: plain(result.record) for result in work(recording.header.scene, views, playback.start)}
    if rest := playback.rest():
        raise RecordingError(f"{rest} recorded calls are not asked for any more; record it anew with this version")
    was = recording.results()
    return [name for name in {**was, **again} if was.get(name) != again.get(name)]


def compared(recording: Recording, backend: str) -> list[Summary]:
    """The answers of `backend` that differ from the recorded ones; none may differ for the recording's own backend."""
    rules: Sequence[Any] = () if recording.header.backend == backend else RULES
    return summaries(list(replayed(recording, backend)), rules)


def _versions() -> dict[str, str]:
    from ai2thor.build import COMMIT_ID

    return {"ovman": __version__, "ai2thor": version("ai2thor"), "build": str(COMMIT_ID), "procthor": version("procthor")}


def _platform() -> dict[str, str]:
    known = {"system": platform.system(), "release": platform.release(), "machine": platform.machine()}
    try:
        command = ["nvidia-smi", "--query-gpu=name,driver_version", "--format=csv,noheader"]
        said = subprocess.run(command, capture_output=True, text=True, timeout=NAME_LIMIT_S)
    except (OSError, subprocess.TimeoutExpired):
        return known | {"gpu": "none"}
    return known | {"gpu": "; ".join(said.stdout.split("\n")).strip("; ") or "none"}
