"""The folder of a draw: what other commands read of it."""

from __future__ import annotations

import hashlib
import json
from contextlib import suppress
from pathlib import Path

from ovman.draws import DrawError
from ovman.records.draw import EPISODES, Draw

MANIFEST = "manifest.json"


def holds_draw(directory: Path) -> bool:
    """Return whether a folder has the manifest of a draw."""
    with suppress(OSError, ValueError, AttributeError):
        return str(json.loads((directory / MANIFEST).read_bytes()).get("schema", "")).startswith("ovman-draw/")
    return False


def read_draw(directory: Path) -> Draw:
    """Return the manifest of a draw, whose files are as the manifest says. DrawError or RecordError, in one line, for another."""
    path = directory / MANIFEST
    try:
        draw = Draw.parse(path.read_bytes(), str(path))
    except OSError as error:
        raise DrawError(f"{path}: {error.strerror}; name a folder that `ovman draw` wrote") from None
    if EPISODES not in draw.files:
        raise DrawError(f"{path}: files: lacks {EPISODES}; draw again")
    for name, wanted in draw.files.items():
        file = directory / name
        if file.parent != directory or not file.is_file():
            raise DrawError(f"{file}: is not there, and {MANIFEST} names it; draw again")
        if hashlib.sha256(file.read_bytes()).hexdigest() != wanted:
            raise DrawError(f"{file}: was changed after it was drawn (sha256); draw again from the same seed")
    return draw


def locate_episodes(path: Path) -> tuple[Path, Draw | None]:
    """Return the file of episodes at a path, and the draw if the path is the folder of one. Errors as for `read_draw`."""
    return (path / EPISODES, read_draw(path)) if path.is_dir() else (path, None)
