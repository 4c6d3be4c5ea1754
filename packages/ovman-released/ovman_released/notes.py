"""Notes of systems that did not run: looked for again by the next Snakemake."""

from __future__ import annotations

import os
from pathlib import Path

from ovman.records.note import Note


def forget_failure(path: Path) -> None:
    """Age the note of a system that did not run, so that what was missing is looked for again; no note is no error.

    Snakemake makes an output again that is older than its input, but not one that is gone while what follows is there.
    Raises RecordError for a file that is not a note.
    """
    if path.exists() and not Note.load(path).ran:
        os.utime(path, (1, 1))
