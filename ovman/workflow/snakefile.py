"""What the Snakefile does beyond its rules: the environment of jobs, what stands in their way, and what is said of dead ones.

Imports nothing heavy: the Snakefile imports it. What it uses of Snakemake is in `ovman.workflow.snakemake_internals`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ovman import kernels
from ovman.settings import Settings
from ovman.settings.config import ConfigError, file_with
from ovman.workflow import at_work, provenance, runs
from ovman.workflow.job import AGENTS, WORKFLOW_PID
from ovman.workflow.locks import NoLocksError
from ovman.workflow.snakemake_internals import alone, limit_gpu, overlays

SOURCES = Path(".snakemake", "ovman.sources.json")
"""What the first process found in the code's files; each job would read them again."""
WRITTEN = ("results", "logs", "benchmarks")
"""Folders of a working directory that the jobs write into."""
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


def prepare(workflow: Any) -> None:
    """Make this Snakemake and its jobs safe to kill and to start again; once, before the rules."""
    os.environ.update(ONE_THREAD)
    kernels.hold()
    # Jobs import the code that the digest in their parameter is of, installed or not.
    homes = [str(Path(workflow.basedir, home)) for home in provenance.PACKAGES.values()]
    paths = [*homes, *filter(None, [os.environ.get("PYTHONPATH")])]
    os.environ["PYTHONPATH"] = os.pathsep.join(paths)
    os.environ[WORKFLOW_PID] = str(os.getpid())
    # An agent may lie beside the overlay that names it.
    beside = dict.fromkeys(str(path.parent) for path in overlays(workflow))
    os.environ[AGENTS] = os.pathsep.join(beside)
    sys.path.extend(place for place in beside if place not in sys.path)
    provenance.remember(Path.cwd() / SOURCES)
    limit_gpu(workflow)
    if workflow.is_main_process:
        check_writable(Path.cwd(), () if workflow.dryrun else WRITTEN)
        try:
            no_other = alone(Path.cwd())
        except NoLocksError as error:
            raise SystemExit(str(error)) from None
        if no_other:
            at_work.dead(Path.cwd())
            if not workflow.dryrun:
                runs.begin(Path.cwd())
    else:
        runs.follow(Path.cwd())


def check_writable(directory: Path, folders: Sequence[str]) -> None:
    """SystemExit, in one line, where a working directory or one of its `folders` cannot be written."""
    for place in (directory, directory / ".snakemake", *(directory / folder for folder in folders)):
        if place.exists() and not os.access(place, os.W_OK):
            remedy = "make it writable for this user, or work elsewhere with --directory"
            raise SystemExit(f"{place}: is read-only; {remedy}")


def print_deaths() -> None:
    """Say in one line which job's process ended without a word, and with which arm and episode; for `onerror`."""
    for line in at_work.dead(Path.cwd()):
        print(line, file=sys.stderr, flush=True)


def check_agents(config: Settings, files: Sequence[str | Path]) -> None:
    """Every arm's "module:function" is there, as far as its source tells: nothing is imported.

    files: that the settings were merged from, later ones winning. ConfigError in one line.
    """
    for name, entry in config.arms.items():
        wrong = provenance.lacking(*entry.agent.split(":", 1))
        if wrong is not None:
            file = file_with(files, ("arms", name, "agent"))
            raise ConfigError(f"{file}: arms.{name}.agent is {entry.agent!r}, and {wrong}")
