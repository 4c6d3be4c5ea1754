"""`ovman eval`: an embodied agent on released episodes, outside the workflow and by the same function.

Every finished run is kept in a journal at once. Whoever kills an evaluation and starts it again loses the run that it was in.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path

from ovman.entry.manifest import Manifest, claim, manifest_of
from ovman.entry.progress import Progress
from ovman.entry.release import EntryError, Release
from ovman.entry.results import write_results
from ovman.entry.spread import spread
from ovman.entry.summary import Summary
from ovman.entry.tour_cache import VISITS, TourCache, recording_key
from ovman.evaluation.attempt import run_episode, session_for
from ovman.evaluation.observation_store import ObservationStore
from ovman.evaluation.scores import score
from ovman.models.episode import Episode
from ovman.models.run import Rollout, Score
from ovman.models.settings import Need
from ovman.sim.session import Session
from ovman.workflow.journal import Journal, digest
from ovman.workflow.locks import held
from ovman.workflow.parameter import StageSettings

JOURNAL = "journal.jsonl"


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


def evaluate(
    settings: StageSettings, what: Asked, release: Release, out: Path, cache: Path, say: Callable[[str], None], workers: int = 1
) -> tuple[Manifest, Summary]:
    """Run the arm of the settings, judge it, and write manifest, runs and summary into `out`.

    settings: of the stage `rollouts` for the arm, which needs tours at most. cache: folder of the recorded tours. say: told of
    progress, a line a time. workers: how many processes make the runs. EntryError, AgentError or SimulatorError, in one line;
    finished runs are kept.
    """
    out.mkdir(parents=True, exist_ok=True)
    ids = [episode.id for episode in what.chosen]
    manifest = manifest_of(settings.arm, what.source, what.split, len(what.episodes), ids, what.seeds)
    claim(out, manifest)
    with held(out / ".lock"):
        journal = Journal(out / JOURNAL)
        drive = _drive if workers == 1 else partial(spread, _drive, run_key, workers)
        drive(settings, what, journal, TourCache(cache, say), say)
        runs = [
            _judged(settings, episode, journal[run_key(settings, episode, seed)])
            for seed in what.seeds
            for episode in what.chosen
        ]
    return manifest, write_results(out, runs, what.chosen, manifest, release)


def run_key(settings: StageSettings, episode: Episode, seed: int) -> str:
    """Key of a run in the journal: digest of the arm with its code and constants, the episode, its tours, and the seed."""
    tours = [recording_key(episode, which) for which in VISITS] if Need.TOURS in settings.arm.needs else []
    return digest(settings.canonical, episode.to_json(), tours, seed)


def _drive(settings: StageSettings, what: Asked, journal: Journal, tours: TourCache, say: Callable[[str], None]) -> None:
    """Make the runs that the journal does not have."""
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
                    kept = journal.write(key, session.with_restarts(work).to_json())
                    progress.made(_judged(settings, episode, kept))


def _store(settings: StageSettings, episode: Episode, tours: TourCache, touring: Session) -> ObservationStore:
    places = tours.places(touring, episode) if Need.TOURS in settings.arm.needs else {}
    lens = episode.protocol.camera.field_of_view_deg
    return ObservationStore(settings.arm, settings, lens, Path(episode.scene), elsewhere=places)


def _judged(settings: StageSettings, episode: Episode, record: object) -> Score:
    return score(Rollout.from_json(record, f"{JOURNAL}: {episode.id}"), episode, settings.arm.any_instance)
