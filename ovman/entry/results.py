"""What an evaluation leaves in its folder when all its runs are there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.atomic import replace_bytes
from ovman.entry.manifest import Manifest
from ovman.entry.release import Release
from ovman.entry.run_files import RUNS
from ovman.entry.summary import Summary, as_json, as_text, summary_of
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.run import Score

SUMMARY, PAGE = "summary.json", "summary.md"


def write_results(out: Path, runs: Sequence[Score], episodes: Sequence[Episode], manifest: Manifest, release: Release) -> Summary:
    """Write runs and summary. runs: by seed, each over these episodes in their order."""
    summary = summary_of(runs, episodes, manifest, release)
    replace_bytes(out / RUNS, lines(runs).encode())
    replace_bytes(out / SUMMARY, as_json(summary).encode())
    replace_bytes(out / PAGE, as_text(summary, markdown=True).encode())
    return summary
