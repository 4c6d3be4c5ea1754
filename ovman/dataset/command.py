"""The command `ovman dataset`: from its options to a data set."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from ovman.dataset.about import about
from ovman.dataset.card import SplitOf
from ovman.dataset.making import Sources, make, verify
from ovman.dataset.tours import Recordings
from ovman.entry import CONFIG, DATA, EntryError
from ovman.entry.release import Release
from ovman.evaluation.tours import TourCache
from ovman.perception.libraries import cache as user_cache
from ovman.records.episode import Episode
from ovman.settings.config import load


def run(options: argparse.Namespace, say: Callable[[str], None]) -> list[str]:
    """Make a data set as the options say, or verify one; returns what is wrong with its files afterwards, a line a file.

    say: told of progress, a line a time. EntryError, ConfigError, RecordError, TourError or SimulatorError, in one line.
    """
    out = Path(options.out)
    if not options.verify:
        release = Release(Path(options.release or DATA), load(Path(options.config or CONFIG)))
        cache = user_cache() if options.cache is None else Path(options.cache)
        visits = None if options.visits is None else Path(options.visits)
        recordings = None if options.without_tours else Recordings(visits, TourCache(cache.absolute(), say))
        sources = Sources(release.directory, splits_in(release, options.split), recordings)
        made = make(sources, about(release.directory.resolve().name, options.url, options.date), out, say)
        say(f"{out}: {len(made)} files, {sum(file.size for file in made) / 1e6:.1f} MB")
    return verify(out)


def splits_in(release: Release, names: Sequence[str] | None) -> list[SplitOf]:
    """Some splits of a release with their episodes, None for all that it has. EntryError for a split that it does not have.

    What the main job does not judge is for development.
    """
    every = release.settings.splits
    there = [name for name in every if (release.directory / "episodes" / f"{name}.jsonl").is_file()]
    if not there:
        raise EntryError(f"{release.directory / 'episodes'}: no episodes of any split; name a release with --release")
    test = {name for name, split in every.items() if split.in_main_job}
    return [SplitOf(name, Episode.load(release.episodes(name)), name not in test) for name in dict.fromkeys(names or there)]
