"""The commands `ovman enter` and `ovman leaderboard`: from their options to an entry, and to the tables."""

from __future__ import annotations

import argparse
import datetime
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from ovman.atomic import replace_bytes, replacing
from ovman.cache import Cache
from ovman.draws.folder import read_draw
from ovman.draws.making import check_seed
from ovman.entry import EntryError
from ovman.entry.manifest import COMPRESSED, compress_runs, read_manifest
from ovman.entry.manifest import FILE as MANIFEST
from ovman.entry.release import Release
from ovman.leaderboard.commitment import seed_times
from ovman.leaderboard.entry import FILE, NAME, PREDICTIONS, Entry, Submission, read_entry, write_entry
from ovman.leaderboard.page import TITLE, as_markdown
from ovman.leaderboard.standing import Refusal, Standing, judge_submissions, reasons_against
from ovman.records.draw import Draw
from ovman.settings import Settings
from ovman.settings.config import load

PAGE = "README.md"
REPLAYS = "replays"
"""Folder of a cache that keeps what replays measured."""


def enter(options: argparse.Namespace) -> Path:
    """Make an entry from an evaluation or a file of points, or add it to an entry; return the folder of its split.

    Nothing is replayed.

    Raises:
        EntryError, ConfigError, RecordError: The submission would be refused whatever its runs are.
    """
    source, split, folder = options.source, options.split, options.leaderboard / options.name
    if not NAME.fullmatch(options.name):
        raise EntryError(f"{options.name!r} is no name of an entry; write small letters, digits, - and _")
    entry = _entry(options, folder)
    release = Release(options.release, load(options.config))
    if source.is_dir():
        manifest = read_manifest(source)
        split = manifest.draw or manifest.split
        if split is None:
            raise EntryError(f"{source / MANIFEST}: split: the episodes are neither a released split nor a draw; run it on one")
        if reasons := list(reasons_against(Submission(options.name, entry, split, source, True), manifest, release)):
            raise EntryError(reasons[0])
        files = {MANIFEST: (source / MANIFEST).read_bytes(), COMPRESSED: compress_runs(source)}
    elif split is None:
        raise EntryError(f"{source}: say which split the points are of, with --split")
    else:
        files = {PREDICTIONS: source.read_bytes()}
    if not source.is_dir() or manifest.draw is None:
        release.episodes(split)
    directory: Path = folder / split
    if taken := [name for name in files if (directory / name).exists()]:
        raise EntryError(f"{directory / taken[0]}: is there already; remove it, or choose another name")
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / FILE).exists():
        write_entry(folder, entry)
    with replacing(directory, PREDICTIONS if MANIFEST in files else MANIFEST) as partial:
        if directory.is_dir():
            shutil.copytree(directory, partial)
        partial.mkdir(exist_ok=True)
        for name, content in files.items():
            (partial / name).write_bytes(content)
    return directory


def render_leaderboard(
    options: argparse.Namespace, say: Callable[[str], None]
) -> tuple[Path, Sequence[Standing], Sequence[Refusal]]:
    """Replay and judge all entries, and write the tables. Return the page, what stands and what is refused.

    Entries rank by their runs on the draws of --draw. With --cache, a run that the cache has is judged again but not replayed,
    and the pages say so.

    Raises:
        EntryError, DrawError: The folder is not a leaderboard, or a draw cannot rank; its files stay.
        ConfigError, SimulatorError: In one line.
    """
    release = Release(options.release, load(options.config))
    page = options.directory / PAGE
    if page.exists() and not page.read_text(encoding="utf-8", errors="replace").startswith(f"{TITLE}\n"):
        raise EntryError(f"{page}: is not a page of a leaderboard; name the folder of the entries, or move the file away")
    cache = None if options.cache is None else Cache(options.cache / REPLAYS)
    draws = read_draws(options.draws, release.settings)
    places = {draw.name: directory for draw, directory in zip(draws, options.draws, strict=True)}
    found = list(judge_submissions(options.directory, release, say, options.workers, cache, places))
    replace_bytes(page, as_markdown(found, tuple(release.settings.splits), cache is not None, draws).encode())
    refusals = [one for one in found if isinstance(one, Refusal)]
    return page, [one for one in found if isinstance(one, Standing)], refusals


def read_draws(directories: Sequence[Path], settings: Settings) -> list[Draw]:
    """Return draws that may rank entries. EntryError or DrawError, in one line, for another, and for draws of several designs."""
    draws = [read_draw(directory) for directory in directories]
    for draw, directory in zip(draws, directories, strict=True):
        seed_times(draw)
        check_seed(directory, draw, settings)
        if (draw.split, draw.homes) != (draws[0].split, draws[0].homes):
            raise EntryError(
                f"--draw: {directory} has {draw.homes} homes of {draw.split}, unlike the first; name draws of one kind"
            )
    if len({draw.seed for draw in draws}) < len(draws):
        raise EntryError("--draw: two draws have one seed; name draws of different seeds")
    return draws


def _entry(options: argparse.Namespace, folder: Path) -> Entry:
    """Return the entry of the folder, or of the options. EntryError if both are there, or neither."""
    given = {"system": options.system, "authors": options.authors, "about": options.about}
    if (folder / FILE).exists():
        if said := [name for name, value in given.items() if value]:
            raise EntryError(f"{folder / FILE}: is there already; leave out --{said[0].removesuffix('s')}, or change the file")
        return read_entry(folder)
    if absent := [name for name, value in given.items() if not value]:
        raise EntryError(f"{folder / FILE}: is not there; give --system, --author and --about ({absent[0]} is missing)")
    value = {**given, "role": options.role, "code": options.code, "date": str(datetime.date.today())}
    return Entry.from_json(value, "ovman enter")
