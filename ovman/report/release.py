"""The release: the part of results/ that others need, with a dataset card, checksums and the settings that made it.

A release mirrors results/: `restore` copies it there, and `snakemake --touch` then takes it for the results of this checkout.
`make tables` prints at its end how the results of this checkout differ from the release, `python -m ovman.report.release compare`
at any time.
"""

from __future__ import annotations

import hashlib
import json
import math
import shutil
import subprocess
import sys
import tarfile
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

import ovman
from ovman.atomic import check_own
from ovman.provenance import digest_code
from ovman.records.episode import Episode
from ovman.report.tables.benchmark import rejection_rows
from ovman.report.tables.columns import RELATIONS
from ovman.report.tables.table import pipe_table, read_metrics
from ovman.settings import Settings
from ovman.settings.config import load_files
from ovman.shipped import EMBEDDED, HOME
from ovman_engine.plan import floorplan

RESULTS = Path("results")
FOLDERS = ("scenes", "trials", "certified", "episodes", "sightings", "predictions", "scores", "metrics", "tables", "all")
"""Folders of results/ that are released as files."""
READMITTED = ("readmitted/episodes.jsonl", "readmitted/admissions.jsonl", "readmitted/predictions")
ARCHIVED = ("candidates", "admissible", "rollouts", *READMITTED, "language", "nouns.npz")
"""Files and folders of results/ in `ARCHIVE`."""
CACHES = ("cache/trials", "cache/certified")
"""Caches in `ARCHIVE`: with them a changed threshold starts no simulator."""
ARCHIVE, SUMS, MADE_BY = "measurements.tar.xz", "SHA256SUMS", "made_by.json"
RESTORED, CODE = "restored", "code.txt"
"""Folder of a cache with the released items, and the file in it with the digest of the code that they are restored for."""
NEAR_M = 1.0
"""Distance from a vacated place within which the card counts another instance of the category."""


def write_release(results: Path, output: Path, settings: Settings) -> list[Path]:
    """Write a release of `results` into the folder `output`, which it replaces; return its files, relative and sorted.

    Raises:
        FileNotFoundError: Results are missing.
        ValueError: `output` is neither an older release nor absent.
    """
    missing = [name for name in FOLDERS if not (results / name).is_dir()]
    if missing:
        raise FileNotFoundError(f"{results / missing[0]} is not there; make it first: make all")
    check_own(output, SUMS)
    shutil.rmtree(output, ignore_errors=True)
    for name in FOLDERS:
        shutil.copytree(results / name, output / name, ignore=shutil.ignore_patterns(".*"))
    _pack(results, output / ARCHIVE)
    return stamp(output, settings)


def stamp(release: Path, settings: Settings) -> list[Path]:
    """Write card, checksums, and the settings that made a release; return its files, relative and sorted.

    A constant that was renamed, added or removed without a change of results needs a new stamp: `make golden` shows that they
    are equal.
    """
    made_by = {"version": ovman.__version__, "commit": _commit(), "constants": settings.constants()}
    (release / MADE_BY).write_text(json.dumps(made_by, indent=1) + "\n", encoding="utf-8")
    (release / "README.md").write_text(card(release), encoding="utf-8")
    files = sorted(path.relative_to(release) for path in release.rglob("*") if path.is_file() and path.name != SUMS)
    sums = [f"{hashlib.sha256((release / name).read_bytes()).hexdigest()}  {name.as_posix()}\n" for name in files]
    (release / SUMS).write_text("".join(sums), encoding="utf-8")
    return files


def _pack(results: Path, place: Path) -> None:
    """Write the archive: the same bytes for the same files on every machine and day."""
    roots = [results / name for name in ARCHIVED]
    paths = {path for root in roots for path in ([root] if root.is_file() else root.rglob("*")) if path.is_file()}
    members = {path.relative_to(results).as_posix(): path for path in paths if not path.name.startswith(".")}
    for name in CACHES:
        codes = [folder for folder in (results / name).iterdir() if folder.is_dir()]
        if len(codes) != 1:
            raise ValueError(f"{results / name}: holds items of {len(codes)} versions of the code; remove it and make it again")
        items = (path for path in codes[0].rglob("*") if path.is_file())
        members |= {f"{name}/{RESTORED}/{path.relative_to(codes[0]).as_posix()}": path for path in items}
    with tarfile.open(place, "w:xz", format=tarfile.GNU_FORMAT, preset=6) as archive:
        for name, path in sorted(members.items()):
            member = tarfile.TarInfo(name)
            member.size = path.stat().st_size
            with path.open("rb") as file:
                archive.addfile(member, file)


def _commit() -> str:
    return subprocess.run(["git", "rev-parse", "HEAD"], cwd=HOME, capture_output=True, text=True, check=True).stdout.strip()


def restore(release: Path, results: Path, settings: Settings) -> None:
    """Copy a release to `results`, a folder that does not exist or is empty.

    Raises:
        FileExistsError: There are results already.
        ValueError: The settings are not those that made the release.
        tarfile.FilterError: A file of the archive leads out of `results`.
    """
    if results.exists() and any(results.iterdir()):
        raise FileExistsError(f"{results}: is there already; move it away, or restore into another folder with --directory")
    made_by = json.loads((release / MADE_BY).read_text(encoding="utf-8"))
    then, now = made_by["constants"], json.loads(json.dumps(settings.constants()))
    if differing := sorted(name for name in now if now[name] != then.get(name)):
        says = f"was made with another {differing[0]} ({len(differing)} settings differ)"
        raise ValueError(f"{release.name} {says}; restore with the settings of the release and change them then")
    for name in FOLDERS:
        shutil.copytree(release / name, results / name, copy_function=shutil.copyfile)
    with tarfile.open(release / ARCHIVE) as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)  # Python 3.11.2 has none
        archive.extractall(results)
    for name in CACHES:
        (results / name / RESTORED / CODE).write_text(digest_code(), encoding="utf-8")


def card(results: Path) -> str:
    """Return the dataset card of the episodes in `results`, Markdown."""
    files = sorted((results / "episodes").glob("*.jsonl"), key=lambda path: (path.stem != "main", path.stem))
    every = [episode for file in files for episode in Episode.load(file)]
    episodes = [episode for episode in every if episode.split == "main"]
    kind = {name: floorplan.load(name).kind.replace("_", " ") for name in {e.scene for e in episodes}}
    names = [(e.split, e.relation.value, f"{e.scene} ({kind.get(e.scene)})", e.category) for e in every]
    counted = pd.DataFrame(names, columns=["split", "relation", "scene", "category"])
    main = counted[counted["split"] == "main"]
    rejected = rejection_rows(read_metrics(results / "metrics" / "main" / "rejections.csv"))
    rejected["reason"] = rejected["reason"].str.replace("_", " ")
    instances = Counter(min(e.instances_in_category, 4) for e in episodes)
    shortest = sorted(e.shortest_path_m for e in episodes)
    vacated = [e for e in episodes if e.relation.past]
    return (
        (Path(__file__).parent / "card.md")
        .read_text(encoding="utf-8")
        .format(
            episodes=len(episodes),
            scenes=len(kind),
            trials=sum(len(path.read_text().splitlines()) for path in (results / "trials").glob("*.jsonl")),
            kinds=", ".join(f"{n} {k}{'s' if n > 1 else ''}" for k, n in Counter(kind.values()).most_common()),
            by_relation=_tabulate(_count_relations(main, "split").drop(columns="split")),
            further=_tabulate(_count_relations(counted[counted["split"] != "main"], "split"), 1),
            by_scene=_tabulate(_count_relations(main, "scene"), 1),
            by_category=_tabulate(_count_relations(main, "category"), 1),
            rejections=_tabulate(rejected, 2),
            instances=", ".join(f"{count} with {'four or more' if n == 4 else n}" for n, count in sorted(instances.items())),
            vacated=len(vacated),
            crowded=sum(_has_another_near(e) for e in vacated),
            near=f"{NEAR_M:g}",
            shortest=f"{shortest[0]:.2f}, {shortest[len(shortest) // 2]:.2f} and {shortest[-1]:.2f}",
        )
    )


def _count_relations(episodes: pd.DataFrame, by: str) -> pd.DataFrame:
    """Count the episodes of each relation and all by a column; the largest groups come first."""
    table = pd.crosstab(episodes[by], episodes["relation"]).reindex(columns=RELATIONS, fill_value=0)
    return table.assign(all=table.sum(axis=1)).sort_values("all", ascending=False, kind="stable").reset_index()


def _tabulate(table: pd.DataFrame, words: int = 0) -> str:
    """Format a table whose first `words` columns are text and the others counts, of which zeros are left blank."""
    body = [[str(value or "") for value in row] for row in table.astype(object).to_numpy().tolist()]
    return pipe_table(list(table.columns), body, [index >= words for index in range(len(table.columns))]).rstrip()


def _has_another_near(episode: Episode) -> bool:
    """Return whether an instance of the category is near the answer in the second visit."""
    return any(math.dist(k.position, episode.answer) <= NEAR_M for k in episode.states[1].category(episode.category))


def compare(results: Path, release: Path, settings: Settings) -> Iterator[str]:
    """Say in a few lines what differs from the release: constants, then episodes by split, then tables.

    Files that `results` does not have yet are left out.
    """
    then = json.loads((release / MADE_BY).read_text(encoding="utf-8"))["constants"]
    now = _short(settings.constants())
    changed = [f"{name} {text} -> {now[name]}" for name, text in _short(then).items() if now.get(name, text) != text]
    yield f"constants: {', '.join(changed) or 'as released'}"
    splits = []
    for split in settings.splits:
        made, released = (_lines(folder / "episodes" / f"{split}.jsonl") for folder in (results, release))
        if made and released:
            same = "" if made == released else f", of which {(made & released).total()}"
            splits.append(f"{split} {made.total()}{same} as released")
    if splits:
        yield f"episodes: {', '.join(splits)}"
    differing = {
        path: (_lines(path) - _lines(release / path.relative_to(results))).total()
        for path in sorted(path for folder in ("tables", "all") for path in (results / folder).glob("*.csv"))
        if (release / path.relative_to(results)).is_file()
    }
    if differing:
        others = [f"{path.stem} ({rows})" for path, rows in differing.items() if rows]
        same_tables = f"tables: {len(differing) - len(others)} as released"
        yield same_tables + (f"; rows differ in {', '.join(others)}" if others else "")


def _short(constants: Mapping[str, Any]) -> dict[str, str]:
    """Return the constants that are one short value, as text."""
    return {name: json.dumps(value) for name, value in constants.items() if isinstance(value, bool | int | float | str)}


def _lines(path: Path) -> Counter[str]:
    return Counter(path.read_text(encoding="utf-8").splitlines()) if path.is_file() else Counter()


if __name__ == "__main__":
    command, *folders = sys.argv[1:]
    settings = load_files([HOME / "config.yaml"])
    try:
        if command == "release":
            print(f"{EMBEDDED}: {len(write_release(RESULTS, HOME / EMBEDDED, settings))} files")
        elif command == "compare":
            print(*compare(RESULTS, HOME / EMBEDDED, settings), sep="\n")
        elif command == "stamp":
            stamp(HOME / EMBEDDED, settings)
        else:
            restore(HOME / EMBEDDED, Path(*folders) / RESULTS, settings)
    except (ValueError, FileNotFoundError, FileExistsError) as error:
        raise SystemExit(str(error)) from None
