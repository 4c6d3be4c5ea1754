"""The smallest world that goes through every stage, made once by the real workflow."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.shared import made_once

ROOT = Path(__file__).parents[2]
TINY = ROOT / "overlays" / "tiny.yaml"
TARGET = "results/all"
SNAKEMAKE = (sys.executable, "-m", "snakemake")
Overlay = Mapping[str, Any]


@dataclass(frozen=True)
class World:
    """A directory in which the workflow runs on the tiny world."""

    directory: Path

    def command(self, *arguments: str, overlay: Overlay | None = None, target: str | Sequence[str] = TARGET) -> list[str]:
        """Return the command line of Snakemake. overlay: settings on top of those of the tiny world."""
        files = [str(TINY)]
        if overlay is not None:
            path = self.directory / "overlay.yaml"
            path.write_text(yaml.safe_dump(dict(overlay)))
            files.append(str(path))
        base = [*SNAKEMAKE, "--snakefile", str(ROOT / "Snakefile"), "--directory", str(self.directory), "--cores", "2"]
        targets = [target] if isinstance(target, str) else target
        return [*base, "--configfile", *files, *arguments, "--", *targets]

    def snakemake(
        self, *arguments: str, overlay: Overlay | None = None, target: str | Sequence[str] = TARGET
    ) -> subprocess.CompletedProcess[str]:
        """Run Snakemake to its end; standard error is in stdout."""
        command = self.command(*arguments, overlay=overlay, target=target)
        return subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def planned(self, overlay: Overlay | None = None, target: str | Sequence[str] = TARGET) -> dict[str, int]:
        """Return how many jobs of each rule a dry run plans."""
        said = self.snakemake("--dry-run", overlay=overlay, target=target)
        assert said.returncode == 0, said.stdout
        if "Nothing to be done" in said.stdout:
            return {}
        table = re.search(r"^-+ +-+$\n(.*?)^total", said.stdout, re.MULTILINE | re.DOTALL)
        assert table, said.stdout
        return {rule: int(count) for rule, count in map(str.split, table.group(1).splitlines())}

    def results(self, *names: str) -> dict[str, bytes]:
        """Return the bytes of the files of results/, of some folders if they are named, but for the cache."""
        root = self.directory / "results"
        files = (path for path in root.rglob("*") if path.is_file() and not path.name.startswith("."))
        found = {path.relative_to(root).as_posix(): path.read_bytes() for path in files}
        return {k: v for k, v in found.items() if not k.startswith("cache/") and (not names or k.split("/")[0] in names)}

    def copy(self, place: Path) -> World:
        """Return a copy of the world in another directory."""
        return World(shutil.copytree(self.directory, place))


def finish(directory: Path) -> None:
    """Make the tiny world in a directory."""
    directory.mkdir()
    said = World(directory).snakemake()
    assert said.returncode == 0, said.stdout


@pytest.fixture(scope="session")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    """The finished tiny world: a copy of this process."""
    made = made_once(tmp_path_factory, "world", finish)
    return World(made).copy(tmp_path_factory.mktemp("world") / "copy")
