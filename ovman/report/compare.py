"""Compare the results of this checkout with the release: which constants, episodes and rows of tables differ.

The workflow prints the comparison at the end of a run, `python -m ovman.report.compare` at any time.
"""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from ovman.settings import Settings
from ovman.settings.config import load_files
from ovman.shipped import EMBEDDED, HOME
from ovman.workflow import made
from ovman.workflow.checksums import MADE

TABLES = ("tables", "all")


def print_comparison(settings: Settings) -> None:
    """Print how the results of the working directory differ from the release."""
    for line in compare(MADE, HOME / EMBEDDED, settings):
        print(f"compared with the release: {line}", flush=True)


def compare(results: Path, release: Path, settings: Settings) -> Iterator[str]:
    """Say in a few lines what differs from the release: constants, then episodes by split, then tables.

    Files that `results` does not have yet are left out. FileNotFoundError where the release does not say how it was made.
    """
    then = _constants(release)
    changed = [f"{name} {then[name]} -> {now}" for name, now in _short(settings.constants()) if then.get(name, now) != now]
    yield f"constants: {', '.join(changed) or 'as released'}"
    if episodes := [_episodes(name, results, release) for name in settings.splits if _both(name, results, release)]:
        yield f"episodes: {', '.join(episodes)}"
    same, others = 0, []
    for path in sorted(path for folder in TABLES for path in (results / folder).glob("*.csv")):
        released = release / path.relative_to(results)
        differ = _rows(path) - _rows(released) if released.is_file() else Counter()
        same += not differ
        others += [f"{path.stem} ({differ.total()})"] * bool(differ)
    if same or others:
        yield f"tables: {same} as released" + (f"; rows differ in {', '.join(others)}" if others else "")


def _constants(release: Path) -> dict[str, str]:
    """The constants that are one short value, by name, as the release was made under them."""
    records = (json.loads(text)["constants"] for text in made.read(release).parameters.values())
    return {name: text for record in records for name, text in _short(record)}


def _short(constants: dict[str, object]) -> Iterator[tuple[str, str]]:
    return ((name, json.dumps(value)) for name, value in constants.items() if isinstance(value, bool | int | float | str))


def _both(split: str, results: Path, release: Path) -> bool:
    return all((folder / "episodes" / f"{split}.jsonl").is_file() for folder in (results, release))


def _episodes(split: str, results: Path, release: Path) -> str:
    now, then = (Counter((folder / "episodes" / f"{split}.jsonl").read_text().splitlines()) for folder in (results, release))
    same = (now & then).total()
    return f"{split} {now.total()} as released" if now == then else f"{split} {now.total()}, of which {same} as released"


def _rows(path: Path) -> Counter[tuple[str, ...]]:
    with path.open(newline="", encoding="utf-8") as file:
        return Counter(map(tuple, csv.reader(file)))


if __name__ == "__main__":
    print_comparison(load_files([HOME / "config.yaml"]))
