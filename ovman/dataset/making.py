"""The folder of the data set, made of a release and of recorded tours, one floor plan after the other."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ovman.atomic import SUFFIX, clear_partials, replace_bytes
from ovman.dataset import answers, episodes, parquet, tours
from ovman.dataset.about import About, responsible
from ovman.dataset.card import CARD, SplitOf, card
from ovman.dataset.columns import Table
from ovman.dataset.croissant import croissant
from ovman.dataset.files import DataFile, data_file, sha256
from ovman.dataset.zenodo import zenodo
from ovman.entry import EntryError
from ovman.records.prediction import Prediction
from ovman.records.run import Score

CROISSANT, ZENODO, SUMS = "croissant.json", ".zenodo.json", "SHA256SUMS"
TABLES = (episodes.TABLE, tours.TABLE, answers.RUNS, answers.PREDICTIONS)
"""In the order of the card; the first is the default configuration."""


@dataclass(frozen=True, slots=True)
class Sources:
    """What the data set is made of.

    release: folder of a release; splits: those that are made, in order; recordings: of their tours, None to leave the tours out.
    """

    release: Path
    splits: Sequence[SplitOf]
    recordings: tours.Recordings | None


def make(sources: Sources, about: About, out: Path, say: Callable[[str], None]) -> list[DataFile]:
    """Write the data set into `out`, and return its Parquet files. Those of an earlier making that are not made now are removed.

    say: told of each file, a line. EntryError for a folder that holds something else; TourError, RecordError or SimulatorError.
    """
    refuse_foreign(out)
    out.mkdir(parents=True, exist_ok=True)
    files: list[DataFile] = []

    def written(table: Table, split: str, part: str, groups: Any) -> None:
        name = table.file(split, part)
        file = data_file(out, name, table.name, split, parquet.write(table, groups, out / name))
        say(f"{name}: {file.rows} rows, {file.size / 1e6:.1f} MB")
        files.append(file)

    for split in sources.splits:
        written(episodes.TABLE, split.name, "", [episodes.rows(split.episodes)])
    if (recordings := sources.recordings) is not None:
        for split in sources.splits:
            for scene, toured in tours.tours_of(split.episodes).items():
                places = recordings.places(scene, toured)
                written(tours.TABLE, split.name, scene, (tours.rows(tour, place) for tour, place in places))
    of = {episode.id: split.name for split in sources.splits for episode in split.episodes}
    for name, runs in answers.answers_in(sources.release / "scores", Score, of).items():
        written(answers.RUNS, name, "", [answers.run_rows(runs, name)])
    for name, predictions in answers.answers_in(sources.release / "predictions", Prediction, of).items():
        written(answers.PREDICTIONS, name, "", [answers.prediction_rows(predictions, name)])
    _remove_others(out, {file.name for file in files})
    _describe(about, sources.splits, files, out)
    return files


def verify(folder: Path) -> list[str]:
    """Return what is wrong with the files that SHA256SUMS of a folder names, a line for each. EntryError without that file."""
    file = folder / SUMS
    again = f"make it: ovman dataset --out {folder}"
    if not file.is_file():
        raise EntryError(f"{file}: not there; {again}")
    found = []
    for name, digest in read_sums(file).items():
        if not (folder / name).is_file():
            above = folder / Path(name).parts[0]
            found.append(f"{folder / name if above.exists() else above}: not there; {again}")
        elif sha256(folder / name) != digest:
            found.append(f"{folder / name}: its content is not what {SUMS} says; {again}")
    return list(dict.fromkeys(found))


def read_sums(file: Path) -> dict[str, str]:
    """Return the SHA-256 of files by name, as sha256sum writes them. EntryError for a line that is none."""
    lines = [line.split("  ", 1) for line in file.read_text(encoding="utf-8").splitlines()]
    if wrong := next((number for number, line in enumerate(lines, 1) if len(line) != 2), None):
        raise EntryError(f"{file}, line {wrong}: no checksum and name; make it: ovman dataset --out {file.parent}")
    return {name: digest for digest, name in lines}


def refuse_foreign(out: Path) -> None:
    """EntryError for a folder that is no data set, whose files would be replaced. An interrupted making leaves tables alone."""
    own = {table.name for table in TABLES}
    others = [path for path in (out.iterdir() if out.is_dir() else ()) if path.name not in own and path.suffix != SUFFIX]
    if others and not (out / CROISSANT).is_file():
        raise EntryError(f"{out}: holds other files and no {CROISSANT}; name a new folder with --out")


def _remove_others(out: Path, made: set[str]) -> None:
    """The Parquet files of an earlier making that this one did not make, and folders that are empty then."""
    for table in TABLES:
        for file in (out / table.name).rglob("*.parquet"):
            if file.relative_to(out).as_posix() not in made:
                file.unlink()
        for folder in sorted((path for path in (out / table.name).rglob("*") if path.is_dir()), reverse=True):
            if not any(folder.iterdir()):
                folder.rmdir()


def _describe(about: About, splits: Sequence[SplitOf], files: Sequence[DataFile], out: Path) -> None:
    said = responsible()
    tables = [table for table in TABLES if any(file.table == table.name for file in files)]
    beside = {
        CROISSANT: croissant(about, tables, files, said),
        ZENODO: zenodo(about, said["derived_from"]),
    }
    for name in (*beside, CARD, SUMS):
        clear_partials(out / name)
    for name, content in beside.items():
        replace_bytes(out / name, (json.dumps(content, indent=2, ensure_ascii=False) + "\n").encode())
    replace_bytes(out / CARD, card(about, splits, tables, files, said).encode())
    digests = {file.name: file.sha256 for file in files} | {name: sha256(out / name) for name in (*beside, CARD)}
    replace_bytes(out / SUMS, "".join(f"{digest}  {name}\n" for name, digest in digests.items()).encode())
