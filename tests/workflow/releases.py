"""The release of the tiny world, and what is restored from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from ovman.cli import main
from ovman.report.release import release
from tests.workflow.conftest import ROOT, TINY, World

FROM_MAPS = yaml.safe_load((ROOT / "overlays" / "from_maps.yaml").read_text())
CONFIG = ROOT / "config.yaml"


@dataclass(frozen=True)
class Released:
    """The release of the tiny world, and the large archive beside it."""

    folder: Path
    perceived: Path

    @staticmethod
    def within(place: Path) -> Released:
        """The one that `make` leaves in a folder."""
        return Released(place / "release", place / "perceived.tar.xz")


def make(world: World, place: Path) -> None:
    """Release a finished world into a folder that is not there yet."""
    place.mkdir()
    made = Released.within(place)
    release(world.directory / "results", made.folder, "a card", made.perceived)


def command(of: Released, directory: Path, *further: str, overlays: Sequence[Path] = ()) -> list[str]:
    files = [str(path) for path in (TINY, *overlays)]
    where = ["--release", str(of.folder), "--directory", str(directory), "--config", str(CONFIG), "--configfile", *files]
    return ["restore", *where, *further]


def restored(of: Released, directory: Path, perceived: bool = True) -> World:
    directory.mkdir()
    further = ["--from", str(of.perceived)] if perceived else []
    assert main(command(of, directory, *further)) == 0
    return World(directory)
