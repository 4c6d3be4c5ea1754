"""`ovman verify`: replay the recorded actions of an evaluation on this machine's engine, and score them again.

The agent is not needed and nothing of it is run. An agreement shows that these actions in these episodes come to this score. It
does not show how the agent came by its actions.

The last bits of floating-point arithmetic depend on the processor. A move is blocked or it is not, so a run goes the same way or
another one altogether: its end, its actions and its verdict must be equal. Measurements may differ by what rounding can do:
records hold 0.1 mm, 0.01 degrees and whole pixels; a number between two of these steps may be rounded to either.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from ovman import __version__
from ovman.cache import Cache, digest
from ovman.draws.folder import locate_episodes
from ovman.entry import EntryError
from ovman.entry.evaluation import Progress
from ovman.entry.manifest import FILE, Machine, Manifest, engine_version, read_manifest, read_runs, runs_path, this_machine
from ovman.entry.release import Release
from ovman.entry.summary import SUMMARY, as_json, summarise
from ovman.entry.tables import ENTRIES_KEY
from ovman.evaluation.scores import score_rollout
from ovman.faults import printable
from ovman.processes import WorkerDied, iter_items
from ovman.provenance import ENGINE, digest_code
from ovman.records.episode import SCHEMA, Episode
from ovman.records.run import Rollout, Score
from ovman.runner import Run, open_session, replay
from ovman.settings import Kind, Settings
from ovman.settings.arms import ArmJob
from ovman.sim.session import Session

TOLERANCES: Mapping[str, float] = {"metres": 0.001, "degrees": 0.1, "pixels": 5, "SPL": 0.001}
"""Greatest deviations by unit: ten steps of what a record holds, and for a mask the pixels on its rim, whose rays pass an edge
within rounding. SPL is a quotient of lengths, the shorter of which is in the episode's record."""
MISSING = "nothing"
"""Stands for the value of a key that is missing."""
CLOSE = 1e-9
"""Relative: sums and quotients of the same runs may differ in their last bits between processors."""
At = tuple[str, int]
"""Episode and seed of a run."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """The runs of an evaluation's folder: one per episode and seed that its manifest asks for.

    episodes: by id, in the order of their file. runs: by episode and seed, each with its place, "file:line".
    """

    episodes: Mapping[str, Episode]
    runs: Mapping[At, tuple[str, Score]]


@dataclass(frozen=True, slots=True)
class Verification:
    """The result of a verification.

    Attributes:
        differences: One line each; none if all agrees.
        episodes: Those that are asked for, in the order of their file.
        runs: The recorded runs.
        differing: Number of runs that differ from their replay.
        deviations: Greatest deviation within tolerance by unit, above 0.
    """

    manifest: Manifest
    differences: Sequence[str]
    episodes: Sequence[Episode]
    runs: Sequence[Score]
    differing: int
    deviations: Mapping[str, float]

    @property
    def agrees(self) -> bool:
        """Whether nothing differs."""
        return not self.differences


def replay_job(settings: Settings, manifest: Manifest) -> tuple[ArmJob, Settings]:
    """Return the arm of the runs of a manifest, whose name their draws follow from, and the settings of its job.

    The agent of the manifest is neither imported nor looked for, and nothing of the truth is handed over.
    """
    arm = ArmJob(
        name=manifest.arm,
        kind=Kind.EMBODIED,
        agent=f"{replay.__module__}:{replay.__name__}",
        embodiment=manifest.embodiment,
        any_instance=manifest.any_instance,
        budget=manifest.budget,
        marks=manifest.marks,
    )
    constants = settings.constants() if manifest.embodiment == "locobot" else {}
    return arm, settings.partial({key: value for key, value in constants.items() if key.startswith("locobot.")})


def verify(
    directory: Path,
    release: Release,
    episodes_file: Path | None,
    say: Callable[[str], None],
    workers: int = 1,
    cache: Cache | None = None,
) -> Verification:
    """Verify the evaluation in `directory`.

    Args:
        directory: Of the evaluation.
        release: The released files.
        episodes_file: Episodes of the runs, if they are not of a released split.
        say: Told of progress.
        workers: Processes, which share the scenes.
        cache: Keeps what replays measured. A run that is in it is scored again but not replayed. An agreement then only shows
            that the runs agree with the cache, and whoever can write the cache may have made them up.

    Raises:
        EntryError, RecordError, SimulatorError: In one line; also for a folder that does not hold a whole evaluation.
    """
    manifest = read_manifest(directory)
    recorded = read_recorded(directory, manifest, release, episodes_file)
    differences = list(check_summary(directory, manifest, recorded, release))
    progress, deviations, differing = Progress(len(recorded.runs), say), dict[str, float](), 0
    for rollout in _replay_all(replay_job(release.settings, manifest), recorded, workers, cache):
        at = rollout.episode, rollout.seed
        replayed = score_rollout(rollout, recorded.episodes[at[0]], manifest.any_instance)
        place, run = recorded.runs[at]
        differ, deviate = compare_runs(run, replayed)
        differences += [f"{place}: {at[0]}, seed {at[1]}: {key}: {a} recorded, {b} here" for key, a, b in differ]
        differing += bool(differ)
        deviations = {unit: max(deviations.get(unit, 0.0), deviate.get(unit, 0.0)) for unit in deviations | deviate}
        progress.say_made(replayed)
    episodes, runs = [*recorded.episodes.values()], [run for _, run in recorded.runs.values()]
    return Verification(manifest, differences, episodes, runs, differing, deviations)


def as_lines(found: Verification) -> list[str]:
    """Return the lines of a verification: differences, remarks and the result. Control characters of files are escaped."""
    total = len(found.runs)
    said = [*found.differences, *(f"note: {line}" for line in remark(found.manifest))]
    apart = ", ".join(f"{value:g} {unit}" for unit, value in sorted(found.deviations.items()))
    within = f"; greatest deviation within tolerance: {apart}" if apart else ""
    result = f"all {total} runs agree with what this machine's engine drives"
    if not found.agrees:
        result = f"{len(found.differences)} differences; {total} runs driven again, {found.differing} differ"
    return [*map(printable, said), f"{FILE}: {found.manifest.arm}: {result}{within}"]


def _replay_all(job: tuple[ArmJob, Settings], recorded: Recorded, workers: int, cache: Cache | None) -> Iterator[Rollout]:
    """Yield the rollouts of the runs, scene by scene."""
    by_episode: dict[str, list[tuple[int, str]]] = {}
    for _, run in recorded.runs.values():
        by_episode.setdefault(run.episode, []).append((run.seed, run.trace or ""))
    scenes = groupby(recorded.episodes.values(), key=lambda one: (one.scene, one.backend, one.protocol))
    pieces = [[(one.to_line(), by_episode[one.id]) for one in alike] for _, alike in scenes]
    code = digest_code("ovman.runner", ENGINE)
    try:
        for rollouts in iter_items(partial(_replay_scene, *job, cache, code), pieces, workers):
            yield from rollouts
    except WorkerDied:
        raise EntryError("a worker process was killed; start the same command again") from None


def _replay_scene(
    arm: ArmJob, settings: Settings, cache: Cache | None, code: str, runs: Sequence[tuple[str, Sequence[tuple[int, str]]]]
) -> list[Rollout]:
    """Replay runs of one scene. runs: Lines of episodes, each with the seeds and traces of its runs."""
    first, rollouts = Episode.parse(runs[0][0]), []
    with open_session(first, arm, settings) as session:
        for line, traces in runs:
            episode = Episode.parse(line)
            for seed, trace in traces:
                measure = partial(_measure, session, Run(episode, arm, seed, settings), trace)
                key = replay_key(arm, settings, code, episode, seed, trace)
                value = measure() if cache is None else cache.get_or_compute(key, measure)
                rollouts.append(Rollout.from_json(value))  # records are rounded when they are written
    return rollouts


def replay_key(arm: ArmJob, settings: Settings, code: str, episode: Episode, seed: int, trace: str) -> str:
    """Return the key of a replay in the cache: digest of code, constants, episode, seed and trace."""
    return digest(code, arm.model_dump(mode="json"), settings.constants(), episode.to_json(), seed, trace)


def _measure(session: Session, run: Run, trace: str) -> dict[str, Any]:
    return session.with_restarts(partial(replay, session, run, trace)).to_json()


def read_recorded(directory: Path, manifest: Manifest, release: Release, episodes_file: Path | None) -> Recorded:
    """Return the evaluation in a folder.

    Raises:
        EntryError, RecordError: Files cannot be read, the episodes are others than those here, or the runs are not those that the
            manifest asks for. One line, for the first fault.
    """
    place, file = directory / FILE, runs_path(directory)
    if episodes_file is None and manifest.split is None:
        raise EntryError(
            f"{place}: split: the episodes are not those of a released split; name their file or draw with --episodes"
        )
    source = release.episodes(manifest.split or "") if episodes_file is None else locate_episodes(episodes_file)[0]
    try:
        every, content = Episode.load(source), source.read_bytes()
    except OSError as error:
        raise EntryError(f"{source}: {error.strerror}; name a file of episodes") from None
    for key, here in (("sha256", hashlib.sha256(content).hexdigest()), ("n", len(every)), ("protocol", SCHEMA)):
        if (there := getattr(manifest, key)) != here:
            raise EntryError(f"{place}: {key}: {there} recorded, {here} in {source}")
    episodes = {episode.id: episode for episode in every if episode.id in {*manifest.asked}}
    if [*episodes] != [*manifest.asked] or not episodes:
        raise EntryError(f"{place}: asked: episodes that are not in {source}, or in another order, or none")
    if len({*manifest.seeds}) < len(manifest.seeds) or not manifest.seeds:
        raise EntryError(f"{place}: seeds: {[*manifest.seeds]} recorded; each stands once, and one is needed")
    runs: dict[At, tuple[str, Score]] = {}
    for where, run in read_runs(file):
        wrong = None
        if run.arm != manifest.arm:
            wrong = f"arm: {run.arm} recorded, {manifest.arm} in {FILE}"
        elif run.episode not in episodes or run.seed not in manifest.seeds:
            wrong = f"recorded, not asked for by {FILE}"
        elif (run.episode, run.seed) in runs:
            wrong = f"recorded in line {runs[run.episode, run.seed][0].rpartition(':')[2]}, too: one run is asked for"
        elif run.trace is None:
            wrong = "trace: nothing recorded, so nothing can be driven again"
        if wrong is not None:
            raise EntryError(f"{where}: {run.episode}, seed {run.seed}: {wrong}")
        runs[run.episode, run.seed] = where, run
    for name, seed in ((name, seed) for seed in manifest.seeds for name in episodes):
        if (name, seed) not in runs:
            raise EntryError(f"{file}: {name}, seed {seed}: {MISSING} recorded, a run is asked for by {FILE}")
    return Recorded(episodes, runs)


def check_summary(directory: Path, manifest: Manifest, recorded: Recorded, release: Release) -> Iterator[str]:
    """Yield one line for each value of summary.json that the recorded runs do not come to. Nothing if there is no such file."""
    path = directory / SUMMARY
    if not path.is_file():
        return
    try:
        there = dict(flatten(json.loads(path.read_text(encoding="utf-8"))))
    except (ValueError, RecursionError):
        yield f"{path}: is no JSON; make it again"
        return
    runs = [recorded.runs[name, seed][1] for seed in manifest.seeds for name in recorded.episodes]
    here = dict(flatten(json.loads(as_json(summarise(runs, [*recorded.episodes.values()], manifest, release)))))
    for key in (key for key in there | here if not key.startswith(ENTRIES_KEY)):
        one, other = there.get(key, MISSING), here.get(key, MISSING)
        numbers = [value for value in (one, other) if isinstance(value, float)]
        is_close = len(numbers) == 2 and math.isclose(*numbers, rel_tol=CLOSE, abs_tol=CLOSE)
        if one != other and not is_close:
            yield f"{path}: {key}: {one} recorded, the runs come to {other}"


def remark(manifest: Manifest) -> Iterator[str]:
    """Yield lines on the agent's place, repeated runs, and versions and machines that are others here. They decide nothing."""
    yield f"{FILE}: the agent ran: {manifest.ran}; this is what the manifest says, and a replay cannot check it"
    if manifest.repeated:
        yield f"{FILE}: repeated: {len(manifest.repeated)} runs took several attempts; the leaderboard counts them as failures"
    for key, here in (("ovman", __version__), ("engine", engine_version())):
        if (there := getattr(manifest, key)) != here:
            yield f"{FILE}: {key}: made with {there}, verified with {here}"
    machine = this_machine()
    for one in manifest.machines:
        if one != machine:
            yield f"{FILE}: machines: made on {_describe(one)}, verified on {_describe(machine)}"


def compare_runs(recorded: Score, replayed: Score) -> tuple[list[tuple[str, Any, Any]], dict[str, float]]:
    """Compare a recorded run with its replay, by the keys of their records.

    Returns:
        (key, recorded, replayed) of what must be equal and is not, or deviates by more than its tolerance; and the greatest
        deviation within its tolerance, by unit, above 0.
    """
    differences, deviations = [], dict[str, float]()
    there, here = dict(flatten(recorded.to_json())), dict(flatten(replayed.to_json()))
    for key in there | here:
        one, other = there.get(key, MISSING), here.get(key, MISSING)
        if one == other:
            continue
        unit = unit_of(key)
        apart = _deviation(unit, one, other)
        if unit is None or apart is None or apart > TOLERANCES[unit]:
            differences.append((key, one, other))
        else:
            deviations[unit] = max(deviations.get(unit, 0.0), apart)
    return differences, deviations


def unit_of(key: str) -> str | None:
    """Return the unit of the number under a key such as "visible_px.30", None for what must be equal."""
    *above, last = key.split(".")
    if "visible_px" in above:
        return "pixels"
    if last.endswith("_m") or "path_at_m" in above or (above == ["stop"] and last in ("x", "z")):
        return "metres"
    if last.endswith("_deg"):
        return "degrees"
    return "SPL" if last == "spl" else None


def flatten(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of a JSON object by the paths of their keys, joined by dots; an empty object or list is a value."""
    if isinstance(value, Mapping) and value:
        for name, inner in value.items():
            yield from flatten(inner, f"{key}.{name}" if key else str(name))
    elif isinstance(value, list) and value:
        for number, inner in enumerate(value):
            yield from flatten(inner, f"{key}[{number}]")
    else:
        yield key, value


def _deviation(unit: str | None, one: Any, other: Any) -> float | None:
    """Return how far two numbers are apart, to six decimals; None if one of them is not a number."""
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in (one, other)):
        return None
    apart: float = abs(one - other)
    return round(min(apart % 360.0, -apart % 360.0) if unit == "degrees" else apart, 6)


def _describe(machine: Machine) -> str:
    return f"{machine.system}, {machine.processors} processors, Python {machine.python}, numpy {machine.numpy}"
