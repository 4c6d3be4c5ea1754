"""The smallest world that goes through every stage, made once by the real workflow."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import yaml

from ovman.workflow.snakefile import SOURCES
from tests.shared import made_once
from tests.workflow import forked

if TYPE_CHECKING:
    from tests.workflow.releases import Released

ROOT = Path(__file__).parents[2]
TINY = ROOT / "overlays" / "tiny.yaml"
TARGET = "results/all"
SNAKEMAKE = (sys.executable, "-m", "snakemake")
AT_ONCE = """
import sys
from snakemake.cli import main
from snakemake.executors import touch

touch.Executor.SLEEPING_TIME = 0.0
sys.exit(main())
"""
"""The same, but for the tenth of a second that --touch sleeps for each job."""


@dataclass(frozen=True)
class World:
    """A directory in which the workflow runs on the tiny world. checkout: the copy of this repository whose code runs."""

    directory: Path
    checkout: Path = ROOT

    def command(
        self, *arguments: str, overlay: Mapping[str, Any] | None = None, target: str | Sequence[str] = TARGET
    ) -> list[str]:
        """The command line of Snakemake. overlay: settings on top of those of the tiny world; target: one or several."""
        files = [str(TINY)]
        if overlay is not None:
            path = self.directory / "overlay.yaml"
            path.write_text(yaml.safe_dump(dict(overlay)))
            files.append(str(path))
        base = [*SNAKEMAKE, "--snakefile", str(self.checkout / "Snakefile"), "--directory", str(self.directory)]
        targets = [target] if isinstance(target, str) else target
        return [*base, "--cores", "2", "--configfile", *files, *arguments, "--", *targets]

    def snakemake(
        self, *arguments: str, overlay: Mapping[str, Any] | None = None, target: str | Sequence[str] = TARGET
    ) -> subprocess.CompletedProcess[str]:
        """Run it to its end; standard error is in stdout."""
        command = self.command(*arguments, overlay=overlay, target=target)
        environment = {k: v for k, v in os.environ.items() if k != "OVMAN_WORKFLOW_PID"}
        self.begin_with_sources()
        if self.checkout != ROOT:  # a forked process would have this checkout's modules
            environment["PYTHONPATH"] = str(self.checkout)
            merged = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
            command[: len(SNAKEMAKE)] = [sys.executable, "-c", AT_ONCE]
            return subprocess.run(command, cwd=self.checkout, env=environment, **merged)
        return forked.snakemake(command[len(SNAKEMAKE) :], ROOT, environment)

    def begin_with_sources(self) -> None:
        """Spare a Snakemake that is no fork and begins in an empty directory what is known of the files of the code: reading them
        takes longer than the rest of a dry run, and what is found is by their content."""
        file = self.directory / SOURCES
        if not file.exists() and forked.SOURCES.exists():
            file.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(forked.SOURCES, file)

    def planned(self, overlay: Mapping[str, Any] | None = None, target: str | Sequence[str] = TARGET) -> dict[str, int]:
        """How many jobs of each rule a dry run plans."""
        said = self.snakemake("--dry-run", overlay=overlay, target=target)
        assert said.returncode == 0, said.stdout
        if "Nothing to be done" in said.stdout:
            return {}
        table = re.search(r"^-+ +-+$\n(.*?)^total", said.stdout, re.MULTILINE | re.DOTALL)
        assert table, said.stdout
        return {rule: int(count) for rule, count in map(str.split, table.group(1).splitlines())}

    def results(self) -> dict[str, bytes]:
        """The bytes of everything that a reader of the results sees."""
        kept = (
            *("visits", "trials", "admissible", "certified", "episodes", "detections", "maps", "nouns.npz", "walks", "dualmap"),
            *("labels", "walk_labels", "maintained", "segments", "cues"),
            *("predictions", "readmitted", "rollouts", "scores", "language", "metrics", "tables", "all"),
        )
        roots = [self.directory / "results" / name for name in kept]
        files = [path for root in roots for path in ([root] if root.is_file() else sorted(root.rglob("*"))) if path.is_file()]
        return {str(p.relative_to(self.directory)): p.read_bytes() for p in files if p.name != ".snakemake_timestamp"}

    def units(self) -> Mapping[str, Sequence[str]]:
        """Keys of the finished units in every journal, in the order in which they were finished."""
        journals = sorted((self.directory / "results" / "journal").rglob("*.jsonl"))
        return {
            str(path.relative_to(self.directory)): [json.loads(line)["key"] for line in path.read_text().splitlines()]
            for path in journals
        }


def finish(directory: Path) -> None:
    """Make the tiny world in a directory."""
    directory.mkdir()
    said = World(directory).snakemake()
    assert said.returncode == 0, said.stdout


@pytest.fixture(scope="session")
def world(tmp_path_factory) -> World:
    """The tiny world, finished: this process's copy of the one that was made."""
    made = made_once(tmp_path_factory, "world", finish)
    return World(shutil.copytree(made, tmp_path_factory.mktemp("world") / "copy"))


@pytest.fixture(scope="session")
def released(world, tmp_path_factory) -> Released:
    """The release of the tiny world, and the large archive beside it. No test writes into it."""
    from tests.workflow.releases import Released, make

    return Released.within(made_once(tmp_path_factory, "released", partial(make, world)))
