"""The runs of an evaluation made by several processes, a floor plan at a time. One process alone writes the journal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from ovman.entry.attempts import Attempts
from ovman.entry.progress import Progress
from ovman.entry.source_cache import remembered
from ovman.entry.workers import Send, Work, as_texts, of_texts, shared_out
from ovman.evaluation.scores import score_rollout
from ovman.evaluation.tours import TourCache
from ovman.records.episode import Episode
from ovman.records.run import Rollout, Score
from ovman.workflow.journal import Journal, contents
from ovman.workflow.parameter import StageSettings

if TYPE_CHECKING:
    from ovman.entry.evaluation import Evaluation

Note = Callable[[Mapping[str, Any]], None]
Drive = Callable[..., None]
"""Makes the runs that a journal lacks: of an evaluation, by what makes its agents, journal, tours, note, say."""


class Keeping(Protocol):
    """The part of a journal that a maker of runs uses."""

    def __contains__(self, key: str) -> bool: ...

    def __getitem__(self, key: str) -> Any: ...

    def write(self, key: str, record: Any) -> Any:
        """Keep a record, and return it as it reads back."""


@dataclass(frozen=True, slots=True)
class Made:
    """A run that a worker made: its key in the journal, and its record."""

    key: str
    record: Any


@dataclass(frozen=True, slots=True)
class Noted:
    """A run in which the agent failed."""

    record: Mapping[str, Any]


def spread(
    drive: Drive,
    run_key: Callable[[StageSettings, Episode, int], str],
    workers: int,
    doing: Evaluation,
    journal: Journal,
    attempts: Path,
    tours: TourCache,
    note: Note,
    say: Callable[[str], None],
) -> None:
    """Make the runs that the journal does not have as `drive` does, in so many processes.

    run_key: of a run in the journal. attempts: file of the attempts, to which each process appends.
    """
    settings, what = doing.settings, doing.what
    progress = Progress(len(what.chosen) * len(what.seeds), say)
    episodes = {episode.id: episode for episode in what.chosen}

    def judged(record: Any) -> Score:
        run = Rollout.from_json(record, f"{journal.path}")
        return score_rollout(run, episodes[run.episode], settings.arm.any_instance)

    absent = set()
    for episode in what.chosen:
        for seed in what.seeds:
            if (key := run_key(settings, episode, seed)) in journal:
                progress.had(judged(journal[key]))
            else:
                absent.add(episode.id)
    progress.resumed()

    def receive(message: Made | Noted | str) -> None:
        if isinstance(message, str):
            say(message)
        elif isinstance(message, Noted):
            note(message.record)
        else:
            progress.made(judged(journal.write(message.key, message.record)))

    waiting = [episode for episode in what.chosen if episode.id in absent]
    pieces = [as_texts(alike) for _, alike in groupby(waiting, key=lambda episode: episode.scene)]
    without_episodes = replace(doing, what=replace(what, source=b"", episodes=(), chosen=()))
    shared_out(partial(_opened, drive, without_episodes, journal.path, attempts, tours.directory), pieces, workers, receive)


@contextmanager
def _opened(drive: Drive, doing: Evaluation, journal: Path, attempts: Path, cache: Path) -> Iterator[Work[Sequence[str]]]:
    """In a worker: what makes the runs of a floor plan that the journal lacks, by an agent of the worker's own."""
    remembered()
    with doing.opened() as remotes:

        def work(texts: Sequence[str], send: Send) -> None:
            here = replace(doing, what=replace(doing.what, chosen=of_texts(texts)))
            drive(
                here,
                remotes,
                _Sent(journal, send),
                Attempts(attempts),
                TourCache(cache, send),
                lambda record: send(Noted(record)),
                lambda line: None,
            )

        yield work


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
