"""The command `ovman explore`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from ovman.atomic import replace_bytes
from ovman.entry.defaults import CONFIG, DATA
from ovman.entry.release import Release
from ovman.explore.encoding import encoded
from ovman.explore.page import page
from ovman.explore.records import read
from ovman.settings import MAIN
from ovman.settings.config import load


def explore(options: argparse.Namespace, say: Callable[[str], None]) -> Path:
    """Write the page of a split. EntryError, ConfigError or RecordError, in one line."""
    settings = load(Path(options.config or CONFIG))
    directory, split = Path(options.release or DATA), options.split or MAIN
    Release(directory, settings).episodes(split)
    data = encoded(read(directory, settings, split), settings, say)
    out = Path(options.out) if options.out else Path("results" if Path("results").is_dir() else "") / "pages" / "explore.html"
    replace_bytes(out, page(data, settings).encode())
    return out
