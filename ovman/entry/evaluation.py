"""`ovman eval`: an agent runs released episodes, outside the workflow.

Every finished run is kept at once. An evaluation that is killed and started again loses the run that it was in, and makes another
attempt at it. Attempts are counted: one is written to disk before the agent is shown the first observation of its drive. Until
then every attempt tells the agent the same; an agent must not use what it learned by driving for another attempt.
"""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from itertools import groupby
from pathlib import Path

from ovman.agents.interface import VISITS
from ovman.atomic import durable_append, hold_lock
from ovman.cache import Cache, digest
from ovman.draws.folder import locate_episodes
from ovman.entry import EntryError
from ovman.entry.manifest import LOG, Repeated, Where, claim_folder, manifest_of, write_manifest
from ovman.entry.release import Release
from ovman.entry.summary import Summary, write_results
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.scores import score_rollout
from ovman.evaluation.supervision import AgentError
from ovman.evaluation.tours import TourCache, recording_key
from ovman.processes import Step, WorkerDied, clock, iter_items
from ovman.provenance import ENGINE, digest_code
from ovman.records.episode import Episode
from ovman.records.run import Rollout, Score
from ovman.remote.agent import AgentEndpoint, RemoteAgents
from ovman.remote.connection import ConnectionLost
from ovman.remote.isolation import explain
from ovman.runner import Run, open_session, replay, run_episode
from ovman.settings import Need, Settings
from ovman.settings.arms import ArmJob
from ovman.sim.session import Session

FINISHED, ATTEMPTS, FAILURES = "finished", "attempts.jsonl", "failures.jsonl"
"""Files of an evaluation's folder: finished runs, attempts, failures that count as abstentions."""
PART = 24
"""Shuffled episodes that one simulator serves."""
Say = Callable[[str], None]
Made = tuple[Rollout, str | None]
"""A rollout, and the error of an agent that failed and therefore abstained."""


@dataclass(frozen=True, slots=True)
class Selection:
    """The episodes that an agent is to run, each under every seed.

    source: bytes of their file, n its number of episodes. split: the released split that they are, None for others. draw: name of
    the draw that they are, None for others.
    """

    source: bytes
    split: str | None
    draw: str | None
    n: int
    chosen: Sequence[Episode]
    seeds: Sequence[int]


def select_episodes(
    release: Release, split: str | None, episodes_file: Path | None, scenes: Collection[str], seeds: Sequence[int]
) -> Selection:
    """Return the episodes of a split, of a file or of a draw's folder; only those of some scenes if scenes are named.

    EntryError for none; DrawError, in one line, for a draw that was changed.
    """
    if negative := [seed for seed in seeds if seed < 0]:
        raise EntryError(f"--seeds: {negative[0]} is negative; write 0 or more")
    path = release.episodes(split) if episodes_file is None and split is not None else episodes_file
    if path is None:
        raise EntryError("name the episodes: --split NAME or --episodes FILE")
    path, draw = locate_episodes(path)
    try:
        source, episodes = path.read_bytes(), Episode.load(path)
    except OSError as error:
        raise EntryError(f"{path}: {error.strerror}; name a file of episodes") from None
    there = sorted({episode.scene for episode in episodes})
    if absent := [scene for scene in scenes if scene not in there]:
        raise EntryError(f"--scenes: {absent[0]} has no episode; write some of {', '.join(there)}")
    chosen = [episode for episode in episodes if not scenes or episode.scene in scenes]
    if not chosen:
        raise EntryError(f"{path}: holds no episode; name a file that has episodes")
    of_split = split if episodes_file is None else release.split_of(source)
    return Selection(source, of_split, None if draw is None else draw.name, len(episodes), chosen, tuple(dict.fromkeys(seeds)))


@dataclass(frozen=True, slots=True)
class Evaluation:
    """An arm on episodes.

    Attributes:
        settings: Of the arm's job.
        endpoint: The place of the agent, None in the evaluator's process, whose arms need tours at most.
        abstains: Whether a run in which the agent fails counts as an abstention; it ends the evaluation if not.
        out: Folder of the evaluation.
        cache: Folder of the recorded tours.
        code: Digest of the code that runs depend on (`digest_run_code`).
        nonce: See `Run`; with one the episodes come in an order of its own.
    """

    arm: ArmJob
    settings: Settings
    seeds: Sequence[int]
    where: Where
    endpoint: AgentEndpoint | None
    abstains: bool
    out: Path
    cache: Path
    code: str
    nonce: str | None = None

    def key(self, episode: Episode, seed: int) -> str:
        """Return the key of a run: digest of the arm with code and constants, the episode with words and tours, and the seed."""
        tours = [recording_key(episode, which) for which in VISITS] if self.is_toured else []
        entry = self.arm.model_dump(mode="json")
        asked = asdict(Run(episode, self.arm, seed, self.settings).asked)
        return digest(self.code, entry, self.settings.constants(), episode.to_json(), asked, tours, seed)

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
    """Return the digest of the code of an arm's agent, of the runner and of the engine. Errors as for `digest_code`."""
    return digest_code("ovman.runner", ENGINE, arm.agent.partition(":")[0])


def evaluate(doing: Evaluation, selection: Selection, release: Release, say: Say, workers: int = 1) -> Summary:
    """Run the arm, judge it, and write manifest, runs and summary into its folder.

    say: Told of progress, line by line; picklable if there are several workers, which share the scenes.

    Raises:
        EntryError, AgentError, SimulatorError: In one line; finished runs are kept.
    """
    out, episodes = doing.out, selection.chosen
    ids = [episode.id for episode in episodes]
    isolation = doing.endpoint.isolation if doing.endpoint is not None and doing.where is Where.PROCESS else None
    of_source = selection.source, selection.split, selection.n
    planned = manifest_of(doing.arm, *of_source, ids, selection.seeds, doing.where, doing.nonce, isolation, selection.draw)
    manifest = claim_folder(out, planned)
    if added := [seed for seed in manifest.seeds if seed not in selection.seeds]:
        say(f"{out} has seeds {', '.join(map(str, added))} already; they are kept, and the summary is of all")
    doing = replace(doing, seeds=manifest.seeds, nonce=manifest.nonce)
    with hold_lock(out / ".lock"):
        try:
            rollouts = _run_missing(doing, episodes, say, workers)
        finally:
            if doing.endpoint is not None:
                _agents(doing.endpoint).drop()
        number = count_attempts(out / ATTEMPTS)
        repeated = tuple(
            Repeated(episode=name, seed=seed, attempts=number[name, seed])
            for seed in doing.seeds
            for name in ids
            if number[name, seed] > 1
        )
        manifest = manifest.model_copy(update={"repeated": repeated})
        write_manifest(out, manifest)
        scores = [doing.judge(rollouts[episode.id, seed], episode) for seed in doing.seeds for episode in episodes]
        return write_results(out, scores, episodes, manifest, release)


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
    if rollouts:
        say(f"{len(rollouts)} of {len(episodes) * len(doing.seeds)} runs are there already")
    number = count_attempts(doing.out / ATTEMPTS)
    if again := sum((name, seed) in number for name, seeds in missing.items() for seed in seeds):
        say(f"{again} runs are taken again, and the leaderboard counts them as failures; a new --out has none")
    for rollout, error in _make_runs(doing, [by_id[name] for name in missing], missing, say, workers):
        if error is not None:
            say(f"{rollout.episode}, seed {rollout.seed}: {error}; counted as an abstention")
            with (doing.out / FAILURES).open("a", encoding="utf-8") as failures:
                failures.write(json.dumps({"episode": rollout.episode, "seed": rollout.seed, "error": error}) + "\n")
        rollouts[rollout.episode, rollout.seed] = rollout
        progress.say_made(doing.judge(rollout, by_id[rollout.episode]))
    return rollouts


def _make_runs(
    doing: Evaluation, episodes: Sequence[Episode], missing: Mapping[str, Sequence[int]], say: Say, workers: int
) -> Iterator[Made]:
    """Yield the runs of episodes under the seeds that they miss, as they are made."""
    alike = groupby(episodes, key=lambda one: (one.scene, one.backend, one.protocol))
    scenes = [[one.to_line() for one in group] for _, group in alike]  # episodes cannot be pickled
    if doing.nonce is not None:
        scenes = list_shuffled(episodes, doing.nonce)
    if min(workers, len(scenes)) < 2:
        for scene in scenes:
            yield from _run_scene(doing, missing, say, scene)
        return
    try:
        for made in iter_items(partial(_list_scene, doing, missing, say), scenes, workers):
            yield from made
    except WorkerDied:
        raise EntryError("a worker process was killed; finished runs are kept, and the same command goes on") from None


def list_shuffled(episodes: Sequence[Episode], nonce: str) -> list[list[str]]:
    """Return the lines of episodes in an order that follows from the nonce, in parts that may share a simulator.

    Two episodes of a scene then have others between them, and their order says nothing about them.
    """
    order = sorted(episodes, key=lambda one: (one.backend, str(one.protocol), digest(nonce, one.id)))
    alike = [[one.to_line() for one in group] for _, group in groupby(order, key=lambda one: (one.backend, one.protocol))]
    return [group[k : k + PART] for group in alike for k in range(0, len(group), PART)]


def _list_scene(doing: Evaluation, missing: Mapping[str, Sequence[int]], say: Say, lines: Sequence[str]) -> list[Made]:
    return list(_run_scene(doing, missing, say, lines))


def _run_scene(doing: Evaluation, missing: Mapping[str, Sequence[int]], say: Say, lines: Sequence[str]) -> Iterator[Made]:
    """Make the runs of episodes that may share a simulator, and keep each. lines: The records of the episodes."""
    episodes, arm, tours = [Episode.parse(line) for line in lines], doing.arm, TourCache(doing.cache, say)
    first, agents = episodes[0], None if doing.endpoint is None else _agents(doing.endpoint)
    if agents is not None:
        agents.connect()  # an agent that cannot be loaded is told of before a tour is recorded
    # A tour is recorded with the benchmark's body, whatever the arm's is. Neither starts a simulator before its first use.
    with open_session(first, arm, doing.settings) as session, Session(first.scene, first.settings) as touring:
        for episode in episodes:
            session.scene = touring.scene = episode.scene
            places = tours.places(touring, episode) if doing.is_toured else {}
            lens = episode.protocol.camera.field_of_view_deg
            store = ObservationStore(arm, doing.settings, lens, Path(episode.scene), elsewhere=places)
            for seed in missing[episode.id]:
                run, error = Run(episode, arm, seed, doing.settings, store, nonce=doing.nonce), None
                try:
                    rollout = session.with_restarts(partial(_attempt, doing.out / ATTEMPTS, session, run, agents))
                except AgentError as failed:
                    where, error = f"{episode.id}, seed {seed}", str(failed)
                    if doing.where is Where.PROCESS and not isinstance(failed, ConnectionLost):
                        assert doing.endpoint is not None
                        error += f"; {doing.out / LOG} has the traceback{explain(doing.endpoint.isolation, error)}"
                    if not doing.abstains:
                        raise type(failed)(error if where in error else f"{where}: {error}") from None
                    rollout = session.with_restarts(partial(replay, session, run, ""))
                kept = Cache(doing.out / FINISHED).get_or_compute(doing.key(episode, seed), rollout.to_json)
                yield Rollout.from_json(kept, f"{doing.out}: {episode.id}"), error


@cache
def _agents(endpoint: AgentEndpoint) -> RemoteAgents:
    """Return the agents of this process. A server that it started ends with it."""
    return RemoteAgents(endpoint)


def _attempt(attempts: Path, session: Session, run: Run, agents: RemoteAgents | None, is_last: bool = False) -> Rollout:
    """Make a run. If the connection to the agent is lost before its first observation, it is made again, once.

    Raises:
        AgentError: The agent fails; ConnectionLost among them.
    """
    shown = False

    def begin() -> None:
        nonlocal shown
        note_attempt(attempts, run.episode.id, run.seed)
        shown = True

    try:
        return run_episode(session, run, agents, begin)
    except ConnectionLost:
        assert agents is not None
        agents.drop()
        if shown or is_last:
            raise
        return _attempt(attempts, session, run, agents, is_last=True)


def note_attempt(path: Path, episode: str, seed: int) -> None:
    """Write down that an attempt at a run begins. The line survives a SIGKILL from then on; several processes may append."""
    line = json.dumps({"episode": episode, "seed": seed, "attempt": count_attempts(path)[episode, seed] + 1})
    is_torn = path.exists() and not path.read_bytes().endswith(b"\n")  # a kill came in the middle of a line
    durable_append(path, b"\n" * is_torn + f"{line}\n".encode())


def count_attempts(path: Path) -> Counter[tuple[str, int]]:
    """Return the attempts at runs by episode and seed. A torn line does not count: nothing was shown after it."""
    number: Counter[tuple[str, int]] = Counter()
    for line in path.read_bytes().splitlines() if path.exists() else ():
        with suppress(ValueError):
            value = json.loads(line)
            number[value["episode"], value["seed"]] += 1
    return number


class Progress:
    """Lines on how far `total` runs are: runs done, success so far, and the time left at the mean pace until now."""

    def __init__(self, total: int, say: Say) -> None:
        self.done, self._total, self._say = 0, total, say
        self._successes, self._made, self._begun = 0, 0, time.monotonic()

    def count(self, run: Score) -> None:
        """Count a run that was there."""
        self.done, self._successes = self.done + 1, self._successes + run.success

    def say_made(self, run: Score) -> None:
        """Count a run that was made now, and say it."""
        self.count(run)
        self._made += 1
        left_s = (time.monotonic() - self._begun) / self._made * (self._total - self.done)
        ended = f"{run.outcome} after {run.actions} actions, {'success' if run.success else 'failure'}"
        so_far = f"success so far {self._successes / self.done:.3f}, {clock(left_s)} left"
        self._say(Step(self.done, self._total, f"{run.episode} seed {run.seed}: {ended}; {so_far}"))
