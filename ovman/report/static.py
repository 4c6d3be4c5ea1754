"""The stage "static": the tables of the static gate alone, before any agent has driven."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from ovman.analysis import metrics
from ovman.models.settings import Settings
from ovman.report import tables

SHOWN = (metrics.STATIC_RATES, metrics.TAXONOMY, metrics.DIFFICULTY, metrics.BUDGET, metrics.PAIRINGS)


def run(episodes: Path, predictions: Sequence[Path], constants: Settings, output_dir: Path) -> None:
    """Writes the tables of the static arms into output_dir: what the stages "metrics" and "tables" make of them.

    Nothing that needs embodied runs is in them: the taxonomy has no row of what is lost in navigation.
    """
    with TemporaryDirectory() as directory:
        metrics.run(episodes, predictions, [], constants, Path(directory))
        tables.write([tables.table(Path(directory, name), constants) for name in SHOWN], output_dir)
