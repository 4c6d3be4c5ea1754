"""`ovman eval`: an embodied agent on released episodes, outside the workflow and by the same function.

Every finished run is kept in a journal at once. An evaluation that is killed and started again loses the run that it was in.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from ovman.agents.interface import Action, Observation, Query, Visit
from ovman.entry.errors import EntryError
from ovman.entry.manifest import Manifest, Where, claim, manifest_of
from ovman.entry.progress import Progress
from ovman.entry.release import Release
from ovman.entry.results import write_results
from ovman.entry.spread import Keeping, spread
from ovman.entry.summary import Summary
from ovman.entry.tour_cache import VISITS, TourCache, recording_key
from ovman.evaluation.attempt import run_episode, session_for
from ovman.evaluation.observation_store import ObservationStore
from ovman.evaluation.scores import score
from ovman.evaluation.supervision import AgentError
from ovman.models.episode import Episode
from ovman.models.run import Rollout, Score
from ovman.models.settings import Need
from ovman.remote.agent import Remotes
from ovman.remote.elsewhere import Elsewhere, Server
from ovman.remote.line import LineLost
from ovman.sim.session import Session
from ovman.workflow.journal import Journal, digest
from ovman.workflow.locks import held
from ovman.workflow.parameter import StageSettings

JOURNAL, LOG, FAILURES = "journal.jsonl", "agent.log", "failures.jsonl"


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

    settings: of the stage `rollouts` for the arm. elsewhere: the agent, None where it runs in the evaluator's process, whose arms
    need tours at most. abstains: whether a run in which the agent fails counts as an abstention; it else ends the evaluation.
    """

    settings: StageSettings
    what: Asked
    elsewhere: Elsewhere | None = None
    abstains: bool = False

    @property
    def where(self) -> Where:
        """Where the agent runs."""
        if self.elsewhere is None:
            return Where.EVALUATOR
        return Where.SERVER if isinstance(self.elsewhere, Server) else Where.PROCESS

    @contextmanager
    def opened(self) -> Iterator[Remotes | None]:
        """What makes the agents of runs, None where the settings say it."""
        if self.elsewhere is None:
            yield None
        else:
            with self.elsewhere.opened() as remotes:
                yield remotes


def evaluate(
    doing: Evaluation, release: Release, out: Path, cache: Path, say: Callable[[str], None], workers: int = 1
) -> tuple[Manifest, Summary]:
    """Run the arm, judge it, and write manifest, runs and summary into `out`.

    cache: folder of the recorded tours. say: told of progress, a line a time. workers: how many processes make the runs.
    EntryError, AgentError or SimulatorError, in one line; finished runs are kept.
    """
    settings, what = doing.settings, doing.what
    out.mkdir(parents=True, exist_ok=True)
    ids = [episode.id for episode in what.chosen]
    manifest = manifest_of(settings.arm, what.source, what.split, len(what.episodes), ids, what.seeds, doing.where)
    claim(out, manifest)
    with held(out / ".lock"):
        journal, tours, note = Journal(out / JOURNAL), TourCache(cache, say), partial(_note, out / FAILURES, say)
        if workers == 1:
            with doing.opened() as remotes:
                _drive(doing, remotes, journal, tours, note, say)
        else:
            spread(_drive, run_key, workers, doing, journal, tours, note, say)
        runs = [
            _judged(settings, episode, journal[run_key(settings, episode, seed)])
            for seed in what.seeds
            for episode in what.chosen
        ]
    return manifest, write_results(out, runs, what.chosen, manifest, release)


def run_key(settings: StageSettings, episode: Episode, seed: int) -> str:
    """Key of a run in the journal: digest of the arm with its code and constants, the episode, its tours, and the seed."""
    tours = [recording_key(episode, which) for which in VISITS] if _toured(settings) else []
    return digest(settings.canonical, episode.to_json(), tours, seed)


def _drive(
    doing: Evaluation,
    remotes: Remotes | None,
    journal: Keeping,
    tours: TourCache,
    note: Callable[[Mapping[str, Any]], None],
    say: Callable[[str], None],
) -> None:
    """Make the runs that the journal does not have. note: told of each run that is an abstention because the agent failed."""
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
                        run = session.with_restarts(partial(_attempted, work, remotes))
                    except AgentError as error:
                        where = f"{episode.id}, seed {seed}"
                        if not doing.abstains:
                            raise type(error)(str(error) if where in str(error) else f"{where}: {error}") from None
                        note({"episode": episode.id, "seed": seed, "error": str(error)})
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


def _note(file: Path, say: Callable[[str], None], record: Mapping[str, Any]) -> None:
    """Write a line for a run in which the agent failed, and say it."""
    say(f"{record['episode']}, seed {record['seed']}: {record['error']}; counted as an abstention")
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
