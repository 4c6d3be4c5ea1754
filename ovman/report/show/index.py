"""The index of many pages: one row an episode, with the verdict on every arm."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.report.show.page import environment
from ovman.report.show.results import Results
from ovman.report.show.verdicts import embodied_rows, static_rows


def index(results: Results, episodes: Sequence[str], files: Sequence[Path]) -> str:
    """HTML with links to the files, relative to the index; a mark is a verdict, one a seed or run of an arm."""
    rows = []
    for name, file in zip(episodes, files, strict=True):
        episode = results.episodes[name]
        static: dict[str, list[tuple[str, str]]] = {}
        for row in static_rows(results, episode):
            words = row.words if row.run is None else f"run {row.run}: {row.words}"
            static.setdefault(row.arm.name, []).append((row.verdict, words))
        marks = list(static.values())
        marks += [
            [(stop.verdict, f"seed {stop.seed}: {stop.words}") for stop in row.stops] for row in embodied_rows(results, episode)
        ]
        rows.append({"episode": episode, "file": file.as_posix(), "marks": marks})
    arms = sorted(results.arms, key=lambda arm: arm.kind != "static")
    return environment().get_template("index.html").render(rows=rows, arms=arms)
