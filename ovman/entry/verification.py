"""`ovman verify`: the recorded actions of an evaluation driven again on this machine's engine, and judged anew.

The agent is not needed and nothing of it is run. What agrees shows that these actions in these episodes come to this score. It
does not show how the agent came by its actions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path

from ovman.entry.differences import Compared, compared
from ovman.entry.manifest import FILE, Manifest, read_manifest
from ovman.entry.progress import Progress
from ovman.entry.recorded import Recorded, read_recorded, remarks, stated
from ovman.entry.release import Release
from ovman.entry.replay import Replay, replay_settings
from ovman.entry.workers import Send, Work, as_texts, of_texts, shared_out
from ovman.evaluation.scores import score_rollout
from ovman.records.episode import Episode
from ovman.records.record import printable
from ovman.records.run import Rollout, Score
from ovman.runner import Run, open_session, run_episode
from ovman.sim.session import Session
from ovman.workflow.journal import Journal, digest
from ovman.workflow.parameter import StageSettings
from ovman.workflow.provenance import module_digest

ENGINE = "ovman_engine.__main__"
Piece = tuple[Sequence[str], Sequence[Sequence[tuple[int, str]]]]


@dataclass(frozen=True, slots=True)
class Verification:
    """What became of a verification.

    differences: a line each, and none where all agrees. remarks: lines on what is other here and is no difference. driven: runs
    that were driven again; differing: those that differ. deviations: greatest deviation within tolerance by unit, above 0.
    """

    manifest: Manifest
    differences: Sequence[str]
    remarks: Sequence[str]
    runs: Sequence[Score]
    driven: int
    differing: int
    deviations: dict[str, float]

    @property
    def agrees(self) -> bool:
        """Whether every run was driven again and nothing differs."""
        return not self.differences and self.driven == len(self.runs)


def verify(
    directory: Path,
    release: Release,
    episodes_file: Path | None,
    say: Callable[[str], None],
    workers: int = 1,
    journal: Journal | None = None,
) -> Verification:
    """Verify the evaluation in `directory`.

    episodes_file: that the runs are of, where they are of no released split. say: told of progress. journal: keeps what driving
    measured. A run that is in it is judged again but not driven again, so an agreement then shows no more than that the runs
    agree with the journal, which whoever can write it may have made up. EntryError or RecordError, in one line, for what is no
    evaluation; SimulatorError.
    """
    manifest = read_manifest(directory)
    recorded = read_recorded(directory, manifest, release, episodes_file)
    differences = [*recorded.faults, *stated(directory, recorded, release)]
    settings = replay_settings(release.settings, manifest)
    progress = Progress(len(recorded.drivable), say)
    deviations: dict[str, float] = {}
    differing = 0

    def drove(message: tuple[tuple[str, int], Score]) -> None:
        nonlocal differing
        at, driven = message
        place, run = recorded.drivable[at]
        found: Compared = compared(run, driven)
        differences.extend(
            f"{place}: {at[0]}, seed {at[1]}: {key}: {there} recorded, {here} here" for key, there, here in found.differences
        )
        differing += bool(found.differences)
        for unit, apart in found.deviations.items():
            deviations[unit] = max(deviations.get(unit, 0.0), apart)
        progress.made(driven)

    _drive(settings, recorded, journal, workers, drove)
    return Verification(
        manifest=manifest,
        differences=differences,
        remarks=list(remarks(manifest)),
        runs=[run for _, run in recorded.runs],
        driven=progress.done,
        differing=differing,
        deviations=deviations,
    )


def _drive(settings: StageSettings, recorded: Recorded, journal: Journal | None, workers: int, drove: Send) -> None:
    """Drive the recorded runs that the journal does not have, by floor plans; `drove` is told of each run."""
    waiting: list[tuple[Episode, Score]] = []
    keys: dict[tuple[str, int], str] = {}

    def judge(driven: Rollout) -> None:
        judged = score_rollout(driven, recorded.episodes[driven.episode], settings.arm.any_instance)
        drove(((driven.episode, driven.seed), judged))

    def receive(driven: Rollout) -> None:
        if journal is not None:
            journal.write(keys[driven.episode, driven.seed], driven.to_json())
        judge(driven)

    for at, (_, run) in recorded.drivable.items():
        episode = recorded.episodes[run.episode]
        keys[at] = measurement_key(settings, episode, run)
        if journal is not None and keys[at] in journal:
            judge(Rollout.from_json(journal[keys[at]], f"{journal.path}"))
        else:
            waiting.append((episode, run))

    order = {name: number for number, name in enumerate(recorded.episodes)}
    waiting.sort(key=lambda pair: order[pair[0].id])
    pieces = [_piece(list(alike)) for _, alike in groupby(waiting, key=lambda pair: _place(pair[0]))]
    shared_out(partial(_again, settings), pieces, workers, receive)


def measurement_key(settings: StageSettings, episode: Episode, run: Score) -> str:
    """Return the key of what driving a run measures: digest of engine, constants, code that drives, episode, seed and trace."""
    return digest(settings.canonical, module_digest(ENGINE), episode.to_json(), run.seed, run.trace)


def _place(episode: Episode) -> tuple[object, ...]:
    return episode.scene, episode.backend, episode.protocol


def _piece(runs: Sequence[tuple[Episode, Score]]) -> Piece:
    """Runs of one floor plan, the episodes as text: each beside the seeds and traces of its own runs."""
    by_episode: dict[str, list[tuple[int, str]]] = {}
    for episode, run in runs:
        by_episode.setdefault(episode.id, []).append((run.seed, run.trace or ""))
    episodes = {episode.id: episode for episode, _ in runs}
    return as_texts(episodes.values()), [*by_episode.values()]


@contextmanager
def _again(settings: StageSettings) -> Iterator[Work[Piece]]:
    """Drive runs of one floor plan again, and send what is measured of each."""
    yield partial(_drive_again, settings)


def _drive_again(settings: StageSettings, piece: Piece, send: Send) -> None:
    texts, traces = piece
    episodes = of_texts(texts)
    with open_session(episodes[0], settings.arm, settings) as session:
        for episode, runs in zip(episodes, traces, strict=True):
            for seed, trace in runs:
                made = session.with_restarts(partial(_driven, session, episode, seed, trace, settings))
                send(Rollout.from_json(made.to_json()))  # records are rounded when they are written down


def _driven(session: Session, episode: Episode, seed: int, trace: str, settings: StageSettings) -> Rollout:
    return run_episode(session, Run(episode, settings.arm, seed, settings), lambda run: Replay(trace))


def as_lines(found: Verification) -> list[str]:
    """Return the lines of a verification: differences, remarks and the result. Control characters of files are escaped."""
    total = len(found.runs)
    said = [*found.differences, *(f"note: {remark}" for remark in found.remarks)]
    apart = ", ".join(f"{value:g} {unit}" for unit, value in sorted(found.deviations.items()))
    within = f"; greatest deviation within tolerance: {apart}" if apart else ""
    came_to = f"all {total} runs agree with what this machine's engine drives"
    if not found.agrees:
        came_to = f"{len(found.differences)} differences; {found.driven} of {total} runs driven again, {found.differing} differ"
    return [*map(printable, said), f"{FILE}: {found.manifest.arm}: {came_to}{within}"]
