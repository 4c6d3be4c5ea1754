"""`ovman eval`: an agent runs released episodes, outside the workflow.

Every finished run is kept at once. An evaluation that is killed and started again loses the run that it was in, and makes another
attempt at it. Attempts are counted: one is written to disk before the agent is shown the first observation of its drive. Until
then every attempt tells the agent the same; an agent must not use what it learned by driving for another attempt.
"""

from __future__ import annotations

import errno
import json
import shutil
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import groupby
from pathlib import Path
from typing import Any

from ovman.agents.interface import VISITS, Action, Observation, Query, Visit
from ovman.atomic import durable_append, hold_lock
from ovman.cache import Cache, digest
from ovman.entry import EntryError
from ovman.entry.manifest import Manifest, Repeated, Where, claim_folder, manifest_of, write_manifest
from ovman.entry.release import Release
from ovman.entry.summary import Summary, write_results
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.scores import score_rollout
from ovman.evaluation.supervision import AgentError, load_agent
from ovman.evaluation.tours import TourCache, recording_key
from ovman.processes import WorkerDied, iter_items
from ovman.progress import clock
from ovman.provenance import ENGINE, digest_code
from ovman.records.episode import Episode
from ovman.records.run import Rollout, Score
from ovman.remote.agent import AgentEndpoint, RemoteAgents
from ovman.remote.connection import ConnectionLost
from ovman.runner import Run, open_session, run_episode
from ovman.settings import Need, Settings
from ovman.settings.arms import ArmJob
from ovman.sim.session import Session

FINISHED, ATTEMPTS, FAILURES, LOG = "finished", "attempts.jsonl", "failures.jsonl", "agent.log"
"""Files of an evaluation's folder: finished runs, attempts, failures that count as abstentions, output of the agent."""
Say = Callable[[str], None]
Made = tuple[Rollout, str | None]
"""A rollout, and the error of an agent that failed and therefore abstained."""


@dataclass(frozen=True, slots=True)
class Selection:
    """The episodes that an agent is to run, each under every seed.

    Attributes:
        source: Bytes of their file.
        split: The released split that they are, None for others.
        n: Number of episodes of the file.
        chosen: The episodes that are run.
        seeds: The seeds.
    """

    source: bytes
    split: str | None
    n: int
    chosen: Sequence[Episode]
    seeds: Sequence[int]


def select_episodes(
    release: Release,
    split: str | None,
    episodes_file: Path | None,
    scenes: Collection[str],
    shard: tuple[int, int],
    seeds: Sequence[int],
) -> Selection:
    """Return the episodes of a split, or of a file; only those of some scenes if scenes are named; and of these a shard.

    shard: (k, m) for the k-th of m shards, k from 1. A shard is a stretch of the file, so it has few scenes.

    Raises:
        EntryError: Nothing is selected.
        RecordError: The file is wrong.
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
    of_split = split if episodes_file is None else release.split_of(source)
    return Selection(source, of_split, len(episodes), chosen, tuple(dict.fromkeys(seeds)))


@dataclass(frozen=True, slots=True)
class Evaluation:
    """An arm on episodes.

    Attributes:
        arm: The arm.
        settings: Of the arm's job.
        seeds: Each episode is run under every one.
        endpoint: The place of the agent, None in the evaluator's process, whose arms need tours at most.
        abstains: Whether a run in which the agent fails counts as an abstention; it ends the evaluation if not.
        out: Folder of the evaluation.
        cache: Folder of the recorded tours.
        code: Digest of the code that runs depend on (`digest_run_code`).
    """

    arm: ArmJob
    settings: Settings
    seeds: Sequence[int]
    endpoint: AgentEndpoint | None
    abstains: bool
    out: Path
    cache: Path
    code: str

    @property
    def where(self) -> Where:
        """Where the agent runs."""
        if self.endpoint is None:
            return Where.EVALUATOR
        return Where.SERVER if self.endpoint.url is not None else Where.PROCESS

    def key(self, episode: Episode, seed: int) -> str:
        """Return the key of a run: digest of the arm with its code and constants, the episode, its tours, and the seed."""
        tours = [recording_key(episode, which) for which in VISITS] if self.is_toured else []
        entry = self.arm.model_dump(mode="json")
        return digest(self.code, entry, self.settings.constants(), episode.to_json(), tours, seed)

    @property
    def is_toured(self) -> bool:
        """Whether the arm is given recorded tours, or artifacts of them."""
        return bool(set(self.arm.needs) - {Need.NETWORKS})

    def finished(self, episode: Episode, seed: int) -> Rollout | None:
        """Return a run that is finished, None if it is not."""
        path = Cache(self.out / FINISHED).path(self.key(episode, seed))
        with suppress(FileNotFoundError, json.JSONDecodeError):
            return Rollout.from_json(json.loads(path.read_bytes()), str(path))
        return None

    def judge(self, rollout: Rollout, episode: Episode) -> Score:
        """Score a run."""
        return score_rollout(rollout, episode, self.arm.any_instance)


def digest_run_code(arm: ArmJob) -> str:
    """Return the digest of the code of an arm's agent, of the runner and of the engine. SyntaxError for a file of the agent's."""
    return digest_code("ovman.runner", ENGINE, arm.agent.partition(":")[0])


def evaluate(doing: Evaluation, selection: Selection, release: Release, say: Say, workers: int = 1) -> tuple[Manifest, Summary]:
    """Run the arm, judge it, and write manifest, runs and summary into its folder.

    Args:
        doing: The evaluation.
        selection: The episodes.
        release: Its baselines are compared with.
        say: Told of progress, line by line.
        workers: Number of processes, which share the scenes.

    Raises:
        EntryError, AgentError, SimulatorError: In one line; finished runs are kept.
    """
    out, episodes = doing.out, selection.chosen
    try:
        out.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise EntryError(f"--out: {out} is a file, or lies below one; name a folder") from None
    ids = [episode.id for episode in episodes]
    planned = manifest_of(doing.arm, selection.source, selection.split, selection.n, ids, selection.seeds, doing.where)
    manifest = claim_folder(out, planned)
    if added := [seed for seed in manifest.seeds if seed not in selection.seeds]:
        say(f"{out} has seeds {', '.join(map(str, added))} already; they are kept, and the summary is of all")
    doing = replace(doing, seeds=manifest.seeds)
    with hold_lock(out / ".lock"), _full_disk_named(out, doing.cache):
        rollouts = _run_missing(doing, episodes, say, workers)
        number = count_attempts([out / ATTEMPTS])
        repeated = [
            Repeated(episode=name, seed=seed, attempts=number[name, seed])
            for seed in doing.seeds
            for name in ids
            if number.get((name, seed), 0) > 1
        ]
        manifest = manifest.model_copy(update={"repeated": tuple(repeated)})
        write_manifest(out, manifest)
        scores = [doing.judge(rollouts[episode.id, seed], episode) for seed in doing.seeds for episode in episodes]
        return manifest, write_results(out, scores, episodes, manifest, release)


def _run_missing(doing: Evaluation, episodes: Sequence[Episode], say: Say, workers: int) -> dict[tuple[str, int], Rollout]:
    """Make the runs that are not finished, and return all runs by episode and seed."""
    rollouts: dict[tuple[str, int], Rollout] = {}
    by_id, progress = {episode.id: episode for episode in episodes}, Progress(len(episodes) * len(doing.seeds), say)
    missing: dict[str, list[int]] = {}
    for episode in episodes:
        for seed in doing.seeds:
            if (rollout := doing.finished(episode, seed)) is None:
                missing.setdefault(episode.id, []).append(seed)
            else:
                rollouts[episode.id, seed] = rollout
                progress.count(doing.judge(rollout, episode))
    progress.say_resumed()
    number = count_attempts([_mend(doing.out / ATTEMPTS)])
    if again := sum((name, seed) in number for name, seeds in missing.items() for seed in seeds):
        say(f"{again} runs are taken again, and the leaderboard counts them as failures; a new --out has none")
    waiting = [episode for episode in episodes if episode.id in missing]
    for rollout, error in _make_runs(doing, waiting, missing, say, workers):
        if error is not None:
            _note_failure(doing.out / FAILURES, rollout, error, say)
        rollouts[rollout.episode, rollout.seed] = rollout
        progress.say_made(doing.judge(rollout, by_id[rollout.episode]))
    return rollouts


def _make_runs(
    doing: Evaluation, episodes: Sequence[Episode], missing: Mapping[str, Sequence[int]], say: Say, workers: int
) -> Iterator[Made]:
    """Yield the runs of episodes under the seeds that they miss, as they are made."""
    scenes = [list(alike) for _, alike in groupby(episodes, key=lambda one: (one.scene, one.backend, one.protocol))]
    if min(workers, len(scenes)) < 2:
        with doing.endpoint.open() if doing.endpoint is not None else nullcontext() as agents:
            if scenes and agents is not None:
                agents.connect()  # an agent that cannot be loaded is told of before a tour is recorded
            for of_scene in scenes:
                yield from _run_scene(doing, of_scene, missing, agents, say)
        return
    pieces = [([one.to_line() for one in of_scene], missing) for of_scene in scenes]
    try:
        for made in iter_items(partial(_run_scene_in_worker, doing), pieces, workers):
            yield from made
    except WorkerDied:
        raise EntryError("a worker process was killed; finished runs are kept, and the same command goes on") from None


def _run_scene_in_worker(doing: Evaluation, piece: tuple[Sequence[str], Mapping[str, Sequence[int]]]) -> list[Made]:
    """Make the runs of a scene in a process that has an agent of its own. Episodes come as lines: they cannot be pickled."""
    lines, missing = piece
    agents = None
    if doing.endpoint is not None:
        agents = _agents_of_worker(doing.endpoint)
        agents.connect()
    return list(_run_scene(doing, [Episode.parse(line) for line in lines], missing, agents, partial(print, flush=True)))


@cache
def _agents_of_worker(endpoint: AgentEndpoint) -> RemoteAgents:
    return RemoteAgents(endpoint)  # its server ends with this process


def _run_scene(
    doing: Evaluation,
    episodes: Sequence[Episode],
    missing: Mapping[str, Sequence[int]],
    agents: RemoteAgents | None,
    say: Say,
) -> Iterator[Made]:
    """Make the runs of episodes that may share a simulator, and keep each."""
    arm, first, tours = doing.arm, episodes[0], TourCache(doing.cache, say)
    # A tour is recorded with the benchmark's body, whatever the arm's is. Neither starts a simulator before its first use.
    with open_session(first, arm, doing.settings) as session, Session(first.scene, first.settings) as touring:
        for episode in episodes:
            places = tours.places(touring, episode) if doing.is_toured else {}
            lens = episode.protocol.camera.field_of_view_deg
            store = ObservationStore(arm, doing.settings, lens, Path(episode.scene), elsewhere=places)
            for seed in missing[episode.id]:
                run, error = Run(episode, arm, seed, doing.settings, store), None
                try:
                    rollout = session.with_restarts(partial(_attempt, doing, session, run, agents))
                except AgentError as failed:
                    where, error = f"{episode.id}, seed {seed}", _with_log(doing, failed)
                    if not doing.abstains:
                        raise type(failed)(error if where in error else f"{where}: {error}") from None
                    rollout = session.with_restarts(partial(run_episode, session, run, lambda _: Abstaining()))
                kept = Cache(doing.out / FINISHED).get_or_compute(doing.key(episode, seed), rollout.to_json)
                yield Rollout.from_json(kept, f"{doing.out}: {episode.id}"), error


def _attempt(doing: Evaluation, session: Session, run: Run, agents: RemoteAgents | None) -> Rollout:
    """Make a run. If the connection to the agent is lost before its first observation, it is made again, once.

    Raises:
        AgentError: The agent fails; ConnectionLost among them.
    """
    shown = False

    def begin() -> None:
        nonlocal shown
        note_attempt(doing.out / ATTEMPTS, run.episode.id, run.seed)
        shown = True

    def make_agent(run: Run) -> Any:
        agent = agents(run) if agents is not None else load_agent(doing.arm.name, doing.arm.agent)(run.context())
        return CountedAgent(agent, begin) if callable(getattr(agent, "act", None)) else agent

    for is_last in (False, True):
        try:
            return run_episode(session, run, make_agent)
        except ConnectionLost:
            assert agents is not None
            agents.drop()
            if is_last or shown:
                raise
    raise AssertionError("the last attempt returns or raises")


def _with_log(doing: Evaluation, error: AgentError) -> str:
    """Return the message of an error, and where the agent's traceback is, if the evaluator started the agent's process."""
    if doing.where is Where.PROCESS and doing.endpoint is not None and not isinstance(error, ConnectionLost):
        return f"{error}; {doing.endpoint.log} has the traceback"
    return str(error)


class Abstaining:
    """Replaces an agent that failed: it abstains at once."""

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


class CountedAgent:
    """An agent whose attempt is noted before its first observation. begin: Notes it."""

    def __init__(self, agent: Any, begin: Callable[[], None]) -> None:
        self._agent, self._begin, self._has_begun = agent, begin, False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._agent, name)

    def act(self, observation: Observation) -> Action:
        """See `Agent.act`."""
        if not self._has_begun:
            self._begin()
            self._has_begun = True
        action: Action = self._agent.act(observation)
        return action


def note_attempt(path: Path, episode: str, seed: int) -> None:
    """Write down that an attempt at a run begins. The line survives a SIGKILL from then on; several processes may append."""
    attempt = count_attempts([path]).get((episode, seed), 0) + 1
    try:
        durable_append(path, f"{json.dumps({'episode': episode, 'seed': seed, 'attempt': attempt})}\n".encode())
    except OSError as error:
        error.says_all = True  # type: ignore[attr-defined]  # a full disk is not the agent's fault
        raise


def count_attempts(paths: Iterable[Path]) -> dict[tuple[str, int], int]:
    """Return the attempts at runs in files by episode and seed. A torn line does not count: nothing was shown after it."""
    number: dict[tuple[str, int], int] = {}
    for path in paths:
        for line in path.read_bytes().splitlines() if path.exists() else ():
            with suppress(ValueError, KeyError, TypeError):
                value = json.loads(line)
                at = value["episode"], int(value["seed"])
                number[at] = max(number.get(at, 0), int(value["attempt"]))
    return number


def _mend(path: Path) -> Path:
    """End a line that a kill has torn, so that the next one is a line of its own."""
    if path.exists() and (content := path.read_bytes()) and not content.endswith(b"\n"):
        durable_append(path, b"\n")
    return path


def _note_failure(file: Path, rollout: Rollout, error: str, say: Say) -> None:
    """Write a line for a run in which the agent failed, and say it."""
    say(f"{rollout.episode}, seed {rollout.seed}: {error}; counted as an abstention")
    with file.open("a", encoding="utf-8") as out:
        out.write(json.dumps({"episode": rollout.episode, "seed": rollout.seed, "error": error}) + "\n")


class Progress:
    """Lines on how far `total` runs are: runs done, success so far, and the time left at the mean pace until now."""

    def __init__(self, total: int, say: Say) -> None:
        self.done, self._total, self._say = 0, total, say
        self._successes, self._made, self._begun = 0, 0, time.monotonic()

    def count(self, run: Score) -> None:
        """Count a run that was there."""
        self.done, self._successes = self.done + 1, self._successes + run.success

    def say_resumed(self) -> None:
        """Say how many runs were there."""
        if self.done:
            self._say(f"{self.done} of {self._total} runs are there already")

    def say_made(self, run: Score) -> None:
        """Count a run that was made now, and say it."""
        self.count(run)
        self._made += 1
        left_s = (time.monotonic() - self._begun) / self._made * (self._total - self.done)
        ended = f"{run.outcome} after {run.actions} actions, {'success' if run.success else 'failure'}"
        so_far = f"success so far {self._successes / self.done:.3f}, {clock(left_s)} left"
        self._say(f"{self.done}/{self._total} {run.episode} seed {run.seed}: {ended}; {so_far}")


@contextmanager
def _full_disk_named(*places: Path) -> Iterator[None]:
    """Turn a full disk into an EntryError that names which of these folders lies on it."""
    try:
        yield
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        fullest = min((place for place in places if place.exists()), key=lambda place: shutil.disk_usage(place).free)
        where = error.filename or fullest
        raise EntryError(f"{where}: {error.strerror}; free some, and the same command goes on") from None
