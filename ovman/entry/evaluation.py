"""`ovman eval`: an embodied agent on released episodes, outside the workflow and by the same function.

Every finished run is kept in a journal at once. An evaluation that is killed and started again loses the run that it was in, and
makes another attempt at it. Attempts are counted (`ovman.entry.attempts`), and the manifest names the runs that took several.
"""

from __future__ import annotations

import errno
import json
import shutil
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from ovman.agents.interface import VISITS, Action, Observation, Query, Visit
from ovman.entry import attempts
from ovman.entry.attempts import Attempts, CountedAgent
from ovman.entry.errors import EntryError
from ovman.entry.manifest import Manifest, Repeated, Where, claim, manifest_of, write_manifest
from ovman.entry.progress import Progress
from ovman.entry.release import Release
from ovman.entry.results import write_results
from ovman.entry.spread import Keeping, spread
from ovman.entry.summary import Summary
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.scores import score_rollout
from ovman.evaluation.supervision import AgentError, load_agent
from ovman.evaluation.tours import TourCache, recording_key
from ovman.records.episode import Episode
from ovman.records.run import Rollout, Score
from ovman.remote.agent import Remotes
from ovman.remote.elsewhere import Elsewhere, OwnProcess, Server
from ovman.remote.line import LineLost
from ovman.runner import Run, open_session, run_episode
from ovman.settings import Need
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
    if negative := [seed for seed in seeds if seed < 0]:
        raise EntryError(f"--seeds: {negative[0]} is negative; write 0 or more")
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
    try:
        out.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise EntryError(f"--out: {out} is a file, or lies below one; name a folder") from None
    ids = [episode.id for episode in what.chosen]
    manifest = claim(out, manifest_of(settings.arm, what.source, what.split, len(what.episodes), ids, what.seeds, doing.where))
    if added := [seed for seed in manifest.seeds if seed not in what.seeds]:
        say(f"{out} has seeds {', '.join(map(str, added))} already; they are kept, and the summary is of all")
    what = replace(what, seeds=manifest.seeds)
    doing = replace(doing, what=what)
    with held(out / ".lock"), _room(out, cache):
        journal, tours, note = Journal(out / JOURNAL), TourCache(cache, say), partial(_note, out / FAILURES, say)
        begun = Attempts(out / attempts.FILE)
        if workers == 1:
            with doing.opened() as remotes:
                _drive(doing, remotes, journal, begun, tours, note, say)
        else:
            spread(_drive, run_key, workers, doing, journal, out / attempts.FILE, tours, note, say)
            begun = Attempts(out / attempts.FILE)
        number = {(episode.id, seed): begun.of(episode.id, seed) for seed in what.seeds for episode in what.chosen}
        repeated = [Repeated(episode=name, seed=seed, attempts=n) for (name, seed), n in number.items() if n > 1]
        manifest = manifest.model_copy(update={"repeated": tuple(repeated)})
        write_manifest(out, manifest)
        runs = [
            _judged(settings, episode, journal[run_key(settings, episode, seed)])
            for seed in what.seeds
            for episode in what.chosen
        ]
        return manifest, write_results(out, runs, what.chosen, manifest, release)


@contextmanager
def _room(*places: Path) -> Iterator[None]:
    """Turn a full disk into an EntryError that names which of these folders lies on it."""
    try:
        yield
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        fullest = min((place for place in places if place.exists()), key=lambda place: shutil.disk_usage(place).free)
        where = error.filename or fullest
        raise EntryError(f"{where}: {error.strerror}; free some, and the same command goes on") from None


def run_key(settings: StageSettings, episode: Episode, seed: int) -> str:
    """Key of a run in the journal: digest of the arm with its code and constants, the episode, its tours, and the seed."""
    tours = [recording_key(episode, which) for which in VISITS] if _toured(settings) else []
    return digest(settings.canonical, episode.to_json(), tours, seed)


def _drive(
    doing: Evaluation,
    remotes: Remotes | None,
    journal: Keeping,
    begun: Attempts,
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
    if again := sum(begun.of(name, seed) > 0 for name, seeds in absent.items() for seed in seeds):
        say(f"{again} runs are taken again, and the leaderboard counts them as failures; a new --out has none")
    waiting = [episode for episode in what.chosen if episode.id in absent]
    if waiting and remotes is not None:
        remotes.line()  # an agent that cannot be loaded is told of before a tour is recorded
    for _, alike in groupby(waiting, key=lambda episode: (episode.scene, episode.backend, episode.protocol)):
        group = list(alike)
        # A tour is recorded with the benchmark's body, whatever the arm's is. Neither starts a simulator before its first use.
        with open_session(group[0], settings.arm, settings) as session, Session(group[0].scene, group[0].settings) as touring:
            for episode in group:
                store = _store(settings, episode, tours, touring)
                for seed, key in absent[episode.id].items():
                    work = partial(run_episode, session, Run(episode, settings.arm, seed, settings, store))
                    begin = partial(begun.begin, episode.id, seed)
                    try:
                        run = session.with_restarts(partial(_attempted, work, doing, remotes, begin))
                    except AgentError as error:
                        where, said = f"{episode.id}, seed {seed}", _with_log(doing, error)
                        if not doing.abstains:
                            raise type(error)(said if where in said else f"{where}: {said}") from None
                        note({"episode": episode.id, "seed": seed, "error": said})
                        run = session.with_restarts(partial(work, make_agent=lambda _: Abstaining()))
                    kept = journal.write(key, run.to_json())
                    progress.made(_judged(settings, episode, kept))


def _attempted(work: Callable[..., Rollout], doing: Evaluation, remotes: Remotes | None, begin: Callable[[], None]) -> Rollout:
    """Make a run. begin: called before the agent is shown the first observation of its drive.

    Where the line to the agent is lost before that, it is dialled again, once. AgentError, LineLost among them, where the agent
    fails.
    """
    arm = doing.settings.arm
    shown = False

    def first() -> None:
        nonlocal shown
        begin()
        shown = True

    def made(run: Run) -> Any:
        agent = remotes(run) if remotes is not None else load_agent(arm.name, arm.agent)(run.context())
        return CountedAgent(agent, first) if callable(getattr(agent, "act", None)) else agent

    for last in (False, True):
        try:
            return work(make_agent=made)
        except LineLost:
            assert remotes is not None
            remotes.lost()
            if last or shown:
                raise
    raise AssertionError("the last attempt returns or raises")


def _with_log(doing: Evaluation, error: AgentError) -> str:
    """Return the message of an error, and where the agent's traceback is, if the evaluator started the agent's process."""
    if isinstance(doing.elsewhere, OwnProcess) and not isinstance(error, LineLost):
        return f"{error}; {doing.elsewhere.log} has the traceback"
    return str(error)


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
    return score_rollout(Rollout.from_json(record, f"{JOURNAL}: {episode.id}"), episode, settings.arm.any_instance)
