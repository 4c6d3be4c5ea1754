"""`ovman check`: what in results/ is missing, torn, changed or stale, a line a file, with the command that makes it again.

Kinds of files have a check each in CHECKS. Which outputs changed settings or code would make anew is Snakemake's to say
(`snakemake -n`).
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from ovman.records.visit import check_visits
from ovman.settings import Settings
from ovman.workflow import checksums, journal

Check = Callable[["Results", Path], Iterator[str]]
"""What is wrong with one file of a kind, each a problem and its remedy in a line that begins with the file."""


@dataclass(frozen=True)
class Results:
    """A working directory with results/, and the settings that it was made with."""

    directory: Path
    settings: Settings


def check_journal(results: Results, path: Path) -> Iterator[str]:
    """Lines of a journal that are torn, changed or without a digest."""
    try:
        faults = journal.contents(results.directory / path).faults
    except OSError as error:
        yield f"{path}: {error.strerror}; remove it, its job makes its units again"
        return
    for fault in faults:
        yield f"{path}, line {fault.line}: {fault.problem}; the next run of its job makes the unit again"


def check_tours(results: Results, path: Path) -> Iterator[str]:
    """Files of a scene's recorded tours that are missing or are not what was recorded."""
    for line in check_visits(results.directory / checksums.MADE, path.stem):
        yield line.replace(f"{results.directory}/", "")


def check_output(results: Results, path: Path) -> Iterator[str]:
    """An output without checksums. What is kept or recorded is no output; a folder's checksums are those of its files."""
    below = path.relative_to(checksums.MADE)
    if below.parts[0] in NO_OUTPUTS or not (results.directory / path).is_file():
        return
    outputs = [checksums.MADE / part for part in (below, *below.parents) if part.parts]
    if not any((results.directory / checksums.path_of(place)).exists() for place in outputs):
        problem = f"has no checksums in {checksums.path_of(path)}, an older version may have made it"
        yield f"{path}: {problem}; make it again: snakemake --cores 2 --force -- {path}"


def check_split(results: Results, path: Path) -> Iterator[str]:
    """Relations of which the split has fewer episodes than the settings ask for."""
    if path.stem not in results.settings.splits:
        return
    found: Counter[str] = Counter()
    try:
        for line in (results.directory / path).read_text(encoding="utf-8").splitlines():
            found[json.loads(line)["relation"]] += 1
    except (ValueError, KeyError, TypeError):
        yield f"{path}: is torn; make it again: snakemake --cores 2 --force -- {path}"
        return
    asked, where = results.settings.splits[path.stem].episodes, f"splits.{path.stem}.episodes"
    short = [f"{relation} {found[relation]} of {wanted}" for relation, wanted in asked if found[relation] < wanted]
    if short and not results.settings.benchmark.allow_short_split:
        remedy = f"raise splits.{path.stem}.draws or lower {where}, then `make tables`"
        yield f"{path}: has fewer episodes than {where} asks for ({', '.join(short)}); {remedy}"


NO_OUTPUTS = frozenset({"checksums", "journal", "visits", "pages", "report.html"})
"""What in results/ is no output of a rule."""
PER_SCENE = {"scenes": ".json", "trials": ".jsonl"} | dict.fromkeys(
    (
        *("detections", "cues", "labels", "maps", "maintained", "dualmap", "segments", "walks", "walk_labels"),
        "readmitted/maps",
    ),
    ".npz",
)
"""Folders of results/ with a file for every scene, and how their names end."""
CHECKS: Mapping[str, Check] = {
    "journal/**/*.jsonl": check_journal,
    "visits/*.json": check_tours,
    "episodes/*.jsonl": check_split,
    "**/*": check_output,
}
"""By the pattern of the files that each looks at, below results/."""


def check(results: Results) -> Iterator[str]:
    """Every fault of the results, a line each; none where all is whole."""
    root = results.directory / checksums.MADE
    if not root.is_dir():
        yield f"{root}: is no folder; give the one that `make tables` wrote"
        return
    yield from missing_scenes(results)
    yield from map(str, checksums.damages(results.directory))
    for pattern, one in CHECKS.items():
        for path in sorted(root.glob(pattern)):
            if not any(part.startswith(".") for part in path.relative_to(root).parts):
                yield from one(results, path.relative_to(results.directory))


def missing_scenes(results: Results) -> Iterator[str]:
    """Scenes of the settings of which a file of a stage is not there, while other scenes' are."""
    for folder, suffix in PER_SCENE.items():
        there = {path.stem for path in (results.directory / checksums.MADE / folder).glob(f"*{suffix}")}
        splits = results.settings.splits.values()
        for scene in dict.fromkeys(scene for split in splits if split.in_main_job for scene in split.scenes):
            path = checksums.MADE / folder / f"{scene}{suffix}"
            recorded = (results.directory / checksums.path_of(path)).exists()  # then `damages` has it
            if there and scene not in there and not recorded:
                yield f"{path}: is missing; make it: snakemake --cores 2 -- {path}"


def folders_not_made(results: Results) -> list[str]:
    """Return the folders with a file for every scene that hold no file."""
    root, folders = results.directory / checksums.MADE, {"visits": ".json"} | PER_SCENE
    return [folder for folder, suffix in folders.items() if not any((root / folder).glob(f"*{suffix}"))]
