"""The runs of an evaluation made by several processes, a floor plan at a time. One process alone writes the journal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ovman.entry.progress import Progress
from ovman.entry.tour_cache import TourCache
from ovman.entry.workers import Send, as_texts, of_texts, shared_out
from ovman.evaluation.scores import score
from ovman.models.episode import Episode
from ovman.models.run import Rollout, Score
from ovman.workflow.journal import Journal, contents
from ovman.workflow.parameter import StageSettings

if TYPE_CHECKING:
    from ovman.entry.evaluation import Asked

Drive = Callable[..., None]
"""Makes the runs that a journal lacks: settings, asked, journal, tours, say."""


@dataclass(frozen=True, slots=True)
class Made:
    """A run that a worker made: its key in the journal, and its record."""

    key: str
    record: Any


def spread(
    drive: Drive,
    run_key: Callable[[StageSettings, Episode, int], str],
    workers: int,
    settings: StageSettings,
    what: Asked,
    journal: Journal,
    tours: TourCache,
    say: Callable[[str], None],
) -> None:
    """Make the runs that the journal does not have as `drive` does, in so many processes. run_key: of a run in the journal."""
    progress = Progress(len(what.chosen) * len(what.seeds), say)
    episodes = {episode.id: episode for episode in what.chosen}

    def judged(record: Any) -> Score:
        run = Rollout.from_json(record, f"{journal.path}")
        return score(run, episodes[run.episode], settings.arm.any_instance)

    absent = set()
    for episode in what.chosen:
        for seed in what.seeds:
            if (key := run_key(settings, episode, seed)) in journal:
                progress.had(judged(journal[key]))
            else:
                absent.add(episode.id)
    progress.resumed()

    def receive(message: Made | str) -> None:
        if isinstance(message, str):
            say(message)
        else:
            progress.made(judged(journal.write(message.key, message.record)))

    waiting = [episode for episode in what.chosen if episode.id in absent]
    pieces = [as_texts(alike) for _, alike in groupby(waiting, key=lambda episode: episode.scene)]
    for_workers = replace(what, source=b"", episodes=(), chosen=())
    shared_out(partial(_of_scene, drive, settings, journal.path, tours.directory, for_workers), pieces, workers, receive)


def _of_scene(
    drive: Drive, settings: StageSettings, journal: Path, cache: Path, what: Asked, texts: Sequence[str], send: Send
) -> None:
    """In a worker: the runs of a floor plan that the journal lacks."""
    drive(settings, replace(what, chosen=of_texts(texts)), _Sent(journal, send), TourCache(cache, send), lambda line: None)


class _Sent:
    """Takes the place of a journal in a worker: has the units of the journal at `path`, and sends what is written."""

    def __init__(self, path: Path, send: Send) -> None:
        self._units, self._send = contents(path).units if path.exists() else {}, send

    def __contains__(self, key: str) -> bool:
        return key in self._units

    def __getitem__(self, key: str) -> Any:
        return self._units[key]

    def write(self, key: str, record: Any) -> Any:
        """Have the process that started this one keep a record."""
        self._send(Made(key, record))
        return record
