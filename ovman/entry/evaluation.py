"""`ovman eval`: an embodied agent on released episodes, outside the workflow and by the same function.

Every finished run is kept in a journal at once. Whoever kills an evaluation and starts it again loses the run that it was in.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from ovman.agents.interface import Action, Observation, Query, Visit
from ovman.atomic import replace_bytes
from ovman.entry.manifest import Manifest, Where, claim, manifest_of
from ovman.entry.release import EntryError, Release
from ovman.entry.summary import Summary, as_json, as_text, summary_of
from ovman.entry.tour_cache import VISITS, TourCache, recording_key
from ovman.evaluation.attempt import run_episode, session_for
from ovman.evaluation.observation_store import ObservationStore
from ovman.evaluation.scores import score
from ovman.evaluation.supervision import AgentError
from ovman.models.episode import Episode
from ovman.models.record import lines
from ovman.models.run import Rollout, Score
from ovman.models.settings import Need
from ovman.remote.agent import Remotes
from ovman.remote.line import LineLost
from ovman.sim.session import Session
from ovman.workflow.journal import Journal, digest
from ovman.workflow.locks import held
from ovman.workflow.parameter import StageSettings

JOURNAL, RUNS, LOG, FAILURES = "journal.jsonl", "runs.jsonl", "agent.log", "failures.jsonl"


@dataclass(frozen=True, slots=True)
class Asked:
    """The episodes that an agent is to run, each under every seed.

    source: the bytes of their file. split: the released split that they are, None for others. episodes: all of the file; chosen:
    those that are run.
    """

    source: bytes
    split: str | None
    episodes: Sequence[Episode]
    chosen: Sequence[Episode]
    seeds: Sequence[int]


def asked(
    release: Release,
    split: str | None,
    episodes_file: Path | None,
    scenes: Collection[str],
    shard: tuple[int, int],
    seeds: Sequence[int],
) -> Asked:
    """The episodes of a split, or of a file; of some scenes where they are named; and of these the k-th of m shards.

    shard: (k, m), k from 1. A shard is a stretch of the file, so it has few scenes. EntryError or RecordError in one line.
    """
    path = release.episodes(split) if episodes_file is None and split is not None else episodes_file
    if path is None:
        raise EntryError("name the episodes: --split NAME or --episodes FILE")
    try:
        source = path.read_bytes()
        episodes = Episode.load(path)
    except OSError as error:
        raise EntryError(f"{path}: {error.strerror}; name a file of episodes") from None
    there = sorted({episode.scene for episode in episodes})
    if absent := [scene for scene in scenes if scene not in there]:
        raise EntryError(f"--scenes: {absent[0]} has no episode; write some of {', '.join(there)}")
    chosen = [episode for episode in episodes if not scenes or episode.scene in scenes]
    part, parts = shard
    chosen = chosen[(part - 1) * len(chosen) // parts : part * len(chosen) // parts]
    if not chosen:
        raise EntryError(f"{path}: no episode is asked for; write fewer shards, or a file that has episodes")
    return Asked(
        source, split if episodes_file is None else release.split_of(source), episodes, chosen, tuple(dict.fromkeys(seeds))
    )


@dataclass(frozen=True, slots=True)
class Evaluation:
    """An arm on episodes.

    settings: of the stage `rollouts` for the arm. where: the agent runs; remotes: makes it where that is another process, None
    where it is the evaluator's, whose arms need tours at most. abstains: whether a run in which the agent fails counts as an
    abstention; it ends the evaluation otherwise.
    """

    settings: StageSettings
    what: Asked
    where: Where = Where.EVALUATOR
    remotes: Remotes | None = None
    abstains: bool = False


def evaluate(doing: Evaluation, release: Release, out: Path, cache: Path, say: Callable[[str], None]) -> tuple[Manifest, Summary]:
    """Run the arm, judge it, and write manifest, runs and summary into `out`.

    cache: folder of the recorded tours. say: told of progress, a line a time. EntryError, AgentError or SimulatorError, in one
    line; finished runs are kept.
    """
    settings, what = doing.settings, doing.what
    out.mkdir(parents=True, exist_ok=True)
    ids = [episode.id for episode in what.chosen]
    manifest = manifest_of(settings.arm, what.source, what.split, len(what.episodes), ids, what.seeds, doing.where)
    claim(out, manifest)
    with held(out / ".lock"):
        journal = Journal(out / JOURNAL)
        _drive(doing, journal, TourCache(cache, say), out / FAILURES, say)
        runs = [
            _judged(settings, episode, journal[run_key(settings, episode, seed)])
            for seed in what.seeds
            for episode in what.chosen
        ]
    summary = summary_of(runs, what.chosen, manifest, release)
    replace_bytes(out / RUNS, lines(runs).encode())
    replace_bytes(out / "summary.json", as_json(summary).encode())
    replace_bytes(out / "summary.md", as_text(summary, markdown=True).encode())
    return manifest, summary


def run_key(settings: StageSettings, episode: Episode, seed: int) -> str:
    """Key of a run in the journal: digest of the arm with its code and constants, the episode, its tours, and the seed."""
    tours = [recording_key(episode, which) for which in VISITS] if _toured(settings) else []
    return digest(settings.canonical, episode.to_json(), tours, seed)


def _drive(doing: Evaluation, journal: Journal, tours: TourCache, failures: Path, say: Callable[[str], None]) -> None:
    """Make the runs that the journal does not have. failures: file that takes a line for each run in which the agent failed."""
    settings, what = doing.settings, doing.what
    progress = Progress(len(what.chosen) * len(what.seeds), say)
    absent: dict[str, dict[int, str]] = {}
    for episode in what.chosen:
        for seed in what.seeds:
            if (key := run_key(settings, episode, seed)) in journal:
                progress.had(_judged(settings, episode, journal[key]))
            else:
                absent.setdefault(episode.id, {})[seed] = key
    progress.resumed()
    waiting = [episode for episode in what.chosen if episode.id in absent]
    for _, alike in groupby(waiting, key=lambda episode: (episode.scene, episode.backend, episode.protocol)):
        group = list(alike)
        # A tour is recorded with the benchmark's body, whatever the arm's is. Neither starts a simulator before its first use.
        with session_for(group[0], settings.arm, settings) as session, Session(group[0].scene, group[0].settings) as touring:
            for episode in group:
                store = _store(settings, episode, tours, touring)
                for seed, key in absent[episode.id].items():
                    work = partial(run_episode, session, episode, settings.arm, seed, settings, store)
                    try:
                        run = session.with_restarts(partial(_attempted, work, doing.remotes))
                    except AgentError as error:
                        where = f"{episode.id}, seed {seed}"
                        if not doing.abstains:
                            raise type(error)(str(error) if where in str(error) else f"{where}: {error}") from None
                        say(f"{where}: {error}; counted as an abstention")
                        _note(failures, {"episode": episode.id, "seed": seed, "error": str(error)})
                        run = session.with_restarts(partial(work, made=lambda _: Abstaining()))
                    kept = journal.write(key, run.to_json())
                    progress.made(_judged(settings, episode, kept))


def _attempted(work: Callable[..., Rollout], remotes: Remotes | None) -> Rollout:
    """A run, begun again once where the line to the agent was lost. AgentError, LineLost among them, where the agent fails."""
    if remotes is None:
        return work()
    try:
        return work(made=remotes)
    except LineLost:
        remotes.lost()
    try:
        return work(made=remotes)
    except LineLost:
        remotes.lost()
        raise


class Abstaining:
    """What drives in the place of an agent that failed: it abstains at once."""

    looks = False

    def familiarise(self, visit: Visit) -> None:
        """See `Agent.familiarise`."""

    def revisit(self, visit: Visit) -> None:
        """See `Agent.revisit`."""

    def ask(self, query: Query) -> None:
        """See `Agent.ask`."""

    def act(self, observation: Observation) -> Action:
        """See `Agent.act`."""
        return Action.ABSTAIN


def _note(file: Path, record: Mapping[str, Any]) -> None:
    with file.open("a", encoding="utf-8") as out:
        out.write(json.dumps(record) + "\n")


def _toured(settings: StageSettings) -> bool:
    """Whether the arm is given recorded tours, or what is made of them."""
    return bool(set(settings.arm.needs) - {Need.NETWORKS})


def _store(settings: StageSettings, episode: Episode, tours: TourCache, touring: Session) -> ObservationStore:
    places = tours.places(touring, episode) if _toured(settings) else {}
    lens = episode.protocol.camera.field_of_view_deg
    return ObservationStore(settings.arm, settings, lens, Path(episode.scene), elsewhere=places)


def _judged(settings: StageSettings, episode: Episode, record: object) -> Score:
    return score(Rollout.from_json(record, f"{JOURNAL}: {episode.id}"), episode, settings.arm.any_instance)


class Progress:
    """Lines on how far an evaluation of `total` runs is: runs done, success so far, time left as runs have taken until now."""

    def __init__(self, total: int, say: Callable[[str], None]) -> None:
        self.done, self._total, self._say = 0, total, say
        self._successes, self._made, self._begun = 0, 0, time.monotonic()

    def had(self, run: Score) -> None:
        """A run that was there."""
        self.done, self._successes = self.done + 1, self._successes + run.success

    def resumed(self) -> None:
        """All runs that were there are counted."""
        if self.done:
            self._say(f"{self.done} of {self._total} runs are there already")

    def made(self, run: Score) -> None:
        """A run that was made now."""
        self.had(run)
        self._made += 1
        left_s = (time.monotonic() - self._begun) / self._made * (self._total - self.done)
        ended = f"{run.outcome} after {run.actions} actions, {'success' if run.success else 'failure'}"
        so_far = f"success so far {self._successes / self.done:.3f}, {_clock(left_s)} left"
        self._say(f"{self.done}/{self._total} {run.episode} seed {run.seed}: {ended}; {so_far}")


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}"
