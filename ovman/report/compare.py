"""Compare the results of this checkout with the release: which constants, episodes and rows of tables differ.

`make tables` prints the comparison at its end, `python -m ovman.report.compare` at any time.
"""

from __future__ import annotations

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
        for path in sorted(path for folder in TABLES for path in (results / folder).glob("*.csv"))
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
    for line in compare(RESULTS, HOME / EMBEDDED, load_files([HOME / "config.yaml"])):
        print(f"compared with the release: {line}", flush=True)
