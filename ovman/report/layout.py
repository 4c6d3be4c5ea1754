"""Which results the release has, and where: as files, in its archive of measurements, in the large archive beside it."""

from __future__ import annotations

from pathlib import Path

from ovman.workflow import checksums

TREES = {name: name for name in ("scenes", "episodes", "trials", "certified", "predictions", "metrics", "tables", "all")} | {
    "scores": "runs"
}
"""Folders of results/, and their names in the release, where they are files that others read."""
MEASUREMENTS = Path("measurements.tar.xz")
"""In the release: what is left of a run but for what networks saw, and the journals of what a simulator did."""
MEASURED = ("candidates", "admissible", "rollouts", "readmitted", "language", "nouns.npz")
JOURNALS = tuple(f"journal/{stage}" for stage in ("scenes", "trials", "certified", "rollouts"))
"""Of results/, in `MEASUREMENTS`, but for `PERCEIVED`."""
PERCEIVED = (
    "readmitted/maps",
    "detections",
    "labels",
    "maps",
    "maintained",
    "segments",
    "cues",
    "walk_labels",
    "dualmap",
)
"""Of results/, in the large archive: what networks saw, and what was derived from it."""


def released(result: str) -> Path | None:
    """Where the release has a file of results/ as a file; None where it is in no tree of it."""
    _, tree, *below = Path(result).parts
    return Path(TREES[tree], *below) if tree in TREES else None


def within(result: str, parts: tuple[str, ...]) -> bool:
    """Whether a file of results/ is one of these files or lies in one of these folders, both below results/."""
    return any(Path(result).is_relative_to(checksums.MADE / part) for part in parts)


def measured(result: str) -> bool:
    """Whether the archive of measurements has a file of results/."""
    return within(result, MEASURED + JOURNALS) and not within(result, PERCEIVED)
