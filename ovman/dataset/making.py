"""Make the folder of the data set from a release and from recorded tours: `ovman dataset`."""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ovman.atomic import SUFFIX, replace_bytes
from ovman.dataset.metadata import About, DataFile, SplitOf, croissant, render_card, zenodo
from ovman.dataset.tables import EPISODES, TABLES, TOURS, Table, Tour, episode_rows, list_tours, read_answers, tour_rows
from ovman.entry import CONFIG, DATA, EntryError
from ovman.entry.release import Release
from ovman.evaluation.tours import TourCache
from ovman.records.episode import Episode
from ovman.records.visit import VisitManifest
from ovman.settings.config import load
from ovman.shipped import user_cache
from ovman.sim.session import Session

CARD, CROISSANT, ZENODO, SUMS = "README.md", "croissant.json", ".zenodo.json", "SHA256SUMS"
ANSWERS = {"runs": "scores", "predictions": "predictions"}
"""The folder below a release of each table of answers."""


def run(options: argparse.Namespace, say: Callable[[str], None]) -> None:
    """Make a data set as the options say. An earlier one in the same folder is replaced.

    Args:
        options: Of the command line.
        say: Called with each line of progress.

    Raises:
        EntryError: An option names something that does not exist, or a folder with other files.
        TourError: A recorded tour is damaged.
        SimulatorError: A tour cannot be recorded.
    """
    out = Path(options.out)
    release = Release(Path(options.release or DATA), load(Path(options.config or CONFIG)))
    about = About.read(release.directory.resolve().name, options.url, options.date)
    splits = read_splits(release, options.split)
    _refuse_other_files(out)
    for name in TABLES:
        shutil.rmtree(out / name, ignore_errors=True)
    files: list[DataFile] = []

    def write(table: Table, split: str, groups: Iterable[Iterable[dict[str, Any]]], part: str = "") -> None:
        path = out / table.file(split, part)
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = table.write(groups, path)
        file = DataFile(table.file(split, part), table.name, split, rows, path.stat().st_size, _sha256(path))
        say(f"{file.name}: {file.rows} rows, {file.size / 1e6:.1f} MB")
        files.append(file)

    for split in splits:
        write(EPISODES, split.name, [episode_rows(split.episodes)])
    if not options.without_tours:
        cache = TourCache((Path(options.cache) if options.cache else user_cache()).absolute(), say)
        for split in splits:
            for scene, tours in list_tours(split.episodes).items():
                places = _places(scene, tours, Path(options.visits) if options.visits else None, cache)
                write(TOURS, split.name, (tour_rows(tour, place) for tour, place in places), scene)
    of = {episode.id: split.name for split in splits for episode in split.episodes}
    for name, folder in ANSWERS.items():
        for split_name, rows in read_answers(release.directory / folder, of).items():
            write(TABLES[name], split_name, [rows])
    _describe(about, splits, files, out)
    say(f"{out}: {len(files)} files, {sum(file.size for file in files) / 1e6:.1f} MB")


def read_splits(release: Release, names: Sequence[str] | None) -> list[SplitOf]:
    """Return splits of a release with their episodes, None for all that it has. Raises EntryError for an unknown split.

    Splits outside the main job are for development.
    """
    every = release.settings.splits
    there = [name for name in every if (release.directory / "episodes" / f"{name}.jsonl").is_file()]
    if not there:
        raise EntryError(f"{release.directory / 'episodes'}: no episodes of any split; name a release with --release")
    return [
        SplitOf(name, Episode.load(release.episodes(name)), not every[name].in_main_job) for name in dict.fromkeys(names or there)
    ]


def read_sums(file: Path) -> dict[str, str]:
    """Return the SHA-256 of files by name, as sha256sum writes them."""
    lines = [line.split("  ", 1) for line in file.read_text(encoding="utf-8").splitlines()]
    return {name: digest for digest, name in lines}


def _refuse_other_files(out: Path) -> None:
    """Raise EntryError for a folder that is not a data set. An interrupted run leaves tables alone."""
    others = [path for path in (out.iterdir() if out.is_dir() else ()) if path.name not in TABLES and path.suffix != SUFFIX]
    if others and not (out / CROISSANT).is_file():
        raise EntryError(f"{out}: holds other files and no {CROISSANT}; name a new folder with --out")


def _places(scene: str, tours: Sequence[Tour], visits: Path | None, cache: TourCache) -> Iterator[tuple[Tour, Path]]:
    """Yield the tours of a floor plan with the folders of their recordings, from `visits` or recorded into the cache."""
    manifests = [] if visits is None else [one for file in sorted(visits.glob("*.json*")) for one in VisitManifest.read(file)]
    recorded = {name: manifest for manifest in manifests if manifest.scene == scene for name in manifest.visits}
    with Session(scene, tours[0].episode.settings) as session:  # it starts for the first tour that is recorded
        for tour in tours:
            name = tour.episode.visits[tour.which]
            if visits is not None and name in recorded:
                yield tour, recorded[name].directory(visits, name)
            else:
                yield tour, cache.places(session, tour.episode)[name]


def _describe(about: About, splits: Sequence[SplitOf], files: Sequence[DataFile], out: Path) -> None:
    contents = {
        CROISSANT: json.dumps(croissant(about, files), indent=2, ensure_ascii=False) + "\n",
        ZENODO: json.dumps(zenodo(about), indent=2, ensure_ascii=False) + "\n",
        CARD: render_card(about, splits, files),
    }
    digests = {file.name: file.sha256 for file in files}
    for name, content in contents.items():
        replace_bytes(out / name, content.encode())
        digests[name] = _sha256(out / name)
    replace_bytes(out / SUMS, "".join(f"{digest}  {name}\n" for name, digest in digests.items()).encode())


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
