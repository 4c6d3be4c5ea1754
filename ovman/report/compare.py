"""Compare the results of this checkout with the release: which constants, episodes and rows of tables differ.

`make tables` prints the comparison at its end, `python -m ovman.report.compare` at any time.
"""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ovman.report.release import MADE_BY, RESULTS
from ovman.settings import Settings
from ovman.settings.config import load_files
from ovman.shipped import EMBEDDED, HOME

TABLES = ("tables", "all")


def compare(results: Path, release: Path, settings: Settings) -> Iterator[str]:
    """Say in a few lines what differs from the release: constants, then episodes by split, then tables.

    Files that `results` does not have yet are left out.
    """
    then = json.loads((release / MADE_BY).read_text(encoding="utf-8"))["constants"]
    now = _short(settings.constants())
    changed = [f"{name} {text} -> {now[name]}" for name, text in _short(then).items() if now.get(name, text) != text]
    yield f"constants: {', '.join(changed) or 'as released'}"
    if episodes := [text for name in settings.splits if (text := _episodes(name, results, release))]:
        yield f"episodes: {', '.join(episodes)}"
    same, others = 0, []
    for path in sorted(path for folder in TABLES for path in (results / folder).glob("*.csv")):
        released = release / path.relative_to(results)
        differ = _rows(path) - _rows(released) if released.is_file() else Counter()
        same += not differ
        others += [f"{path.stem} ({differ.total()})"] * bool(differ)
    if same or others:
        yield f"tables: {same} as released" + (f"; rows differ in {', '.join(others)}" if others else "")


def _short(constants: Mapping[str, Any]) -> dict[str, str]:
    """Return the constants that are one short value, as text."""
    return {name: json.dumps(value) for name, value in constants.items() if isinstance(value, bool | int | float | str)}


def _episodes(split: str, results: Path, release: Path) -> str:
    files = [folder / "episodes" / f"{split}.jsonl" for folder in (results, release)]
    if not all(file.is_file() for file in files):
        return ""
    now, then = (Counter(file.read_text(encoding="utf-8").splitlines()) for file in files)
    same = (now & then).total()
    return f"{split} {now.total()} as released" if now == then else f"{split} {now.total()}, of which {same} as released"


def _rows(path: Path) -> Counter[tuple[str, ...]]:
    with path.open(newline="", encoding="utf-8") as file:
        return Counter(map(tuple, csv.reader(file)))


if __name__ == "__main__":
    for line in compare(RESULTS, HOME / EMBEDDED, load_files([HOME / "config.yaml"])):
        print(f"compared with the release: {line}", flush=True)
