"""Make the folder of the data set from a release and from recorded tours: `ovman dataset`."""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from ovman.atomic import SUFFIX, replace_bytes
from ovman.dataset.metadata import FILES, croissant, render_card
from ovman.dataset.tables import TABLES, Table, Tour, episode_rows, list_tours, read_answers, tour_rows
from ovman.entry import EntryError
from ovman.entry.release import Release
from ovman.evaluation.tours import TourCache
from ovman.records.episode import Episode
from ovman.records.visit import VisitManifest
from ovman.settings.config import load
from ovman.shipped import user_cache
from ovman.sim.session import Session

CARD, CROISSANT, SUMS = "README.md", "croissant.json", "SHA256SUMS"
ANSWERS = {"runs": "scores", "predictions": "predictions"}
"""The folder below a release of each table of answers."""


def run(options: argparse.Namespace, say: Callable[[str], None]) -> None:
    """Make a data set as the options say. An earlier one in the same folder is replaced.

    Raises:
        EntryError: An option names something that does not exist, or a folder with other files.
        TourError: A recorded tour is damaged.
        SimulatorError: A tour cannot be recorded.
    """
    out, release = options.out, Release(options.release, load(options.config))
    splits = read_splits(release, options.split)
    _refuse_other_files(out)
    for name in TABLES:
        shutil.rmtree(out / name, ignore_errors=True)
    files: list[tuple[str, str, str, int, int, str]] = []

    def write(table: Table, split: str, groups: Iterable[Iterable[dict[str, Any]]], part: str = "") -> None:
        name = table.file(split, part)
        path = out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = table.write(groups, path)
        files.append((name, table.name, split, rows, path.stat().st_size, _sha256(path)))
        say(f"{name}: {rows} rows, {path.stat().st_size / 1e6:.1f} MB")

    for split, episodes in splits.items():
        write(TABLES["episodes"], split, [episode_rows(episodes)])
    if not options.without_tours:
        cache = TourCache((Path(options.cache) if options.cache else user_cache()).absolute(), say)
        for split, episodes in splits.items():
            for scene, tours in list_tours(episodes).items():
                places = _places(scene, tours, Path(options.visits) if options.visits else None, cache)
                write(TABLES["tours"], split, (tour_rows(tour, place) for tour, place in places), scene)
    of = {episode.id: split for split, episodes in splits.items() for episode in episodes}
    for name, folder in ANSWERS.items():
        for split, rows in read_answers(release.directory / folder, of).items():
            write(TABLES[name], split, [rows])
    listed = pd.DataFrame(files, columns=FILES)
    name, digests = release.directory.resolve().name, dict(zip(listed.name, listed.sha256, strict=True))
    contents = {
        CROISSANT: json.dumps(croissant(name, listed), indent=2, ensure_ascii=False) + "\n",
        CARD: render_card(release, splits, listed),
    }
    for name, content in contents.items():
        replace_bytes(out / name, content.encode())
        digests[name] = _sha256(out / name)
    replace_bytes(out / SUMS, "".join(f"{digest}  {name}\n" for name, digest in digests.items()).encode())
    say(f"{out}: {len(listed)} files, {listed['size'].sum() / 1e6:.1f} MB")


def read_splits(release: Release, names: Sequence[str] | None) -> dict[str, list[Episode]]:
    """Return the episodes of splits of a release, None for all that it has. Raises EntryError for an unknown split."""
    there = [name for name in release.settings.splits if (release.directory / "episodes" / f"{name}.jsonl").is_file()]
    if not there:
        raise EntryError(f"{release.directory / 'episodes'}: no episodes of any split; name a release with --release")
    return {name: Episode.load(release.episodes(name)) for name in names or there}


def _refuse_other_files(out: Path) -> None:
    """Raise EntryError for a folder that is not a data set. An interrupted run leaves tables alone."""
    others = [path for path in (out.iterdir() if out.is_dir() else ()) if path.name not in TABLES and path.suffix != SUFFIX]
    if others and not (out / CROISSANT).is_file():
        raise EntryError(f"{out}: holds other files and no {CROISSANT}; name a new folder with --out")


def _places(scene: str, tours: Sequence[Tour], visits: Path | None, cache: TourCache) -> Iterator[tuple[Tour, Path]]:
    """Yield the tours of a floor plan with the files of their recordings, from `visits` or recorded into the cache."""
    manifests = [] if visits is None else [one for file in sorted(visits.glob("*.json*")) for one in VisitManifest.read(file)]
    recorded = {name: manifest for manifest in manifests if manifest.scene == scene for name in manifest.visits}
    with Session(scene, tours[0].episode.settings) as session:  # it starts for the first tour that is recorded
        for tour in tours:
            name = tour.episode.visits[tour.which]
            if visits is not None and name in recorded:
                yield tour, recorded[name].tour(visits, name)
            else:
                yield tour, cache.places(session, tour.episode)[name]


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
