"""What the Snakefile asks of Snakemake beyond its rules: no stale lock, one GPU job at a time, no job without its Snakemake, no
looking for work in vain.

Imports nothing heavy: the Snakefile imports it.
"""

from __future__ import annotations

import fcntl
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TextIO

from ovman.models.settings import Settings
from ovman.workflow import at_work, provenance
from ovman.workflow.config import ConfigError, file_with
from ovman.workflow.job import AGENTS, WORKFLOW_PID

ALIVE = Path(".snakemake", "ovman.alive")
"""Every Snakemake that works in a directory shares a lock on this file; the kernel takes it away from those that die."""
SOURCES = Path(".snakemake", "ovman.sources.json")
"""What the first process found in the code's files; each job would read them again."""
WRITTEN = ("results", "logs", "benchmarks")
"""Folders of a working directory that the jobs write into."""
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
_kept: list[TextIO] = []


def prepare(workflow: Any) -> None:
    """Make this Snakemake and its jobs safe to kill and to start again; once, before the rules."""
    os.environ.update(ONE_THREAD)
    # Jobs import the code that the digest in their parameter is of, installed or not.
    homes = [str(Path(workflow.basedir, home)) for home in provenance.PACKAGES.values()]
    paths = [*homes, *filter(None, [os.environ.get("PYTHONPATH")])]
    os.environ["PYTHONPATH"] = os.pathsep.join(paths)
    os.environ[WORKFLOW_PID] = str(os.getpid())
    # An agent may lie beside the overlay that names it.
    beside = dict.fromkeys(str(Path(path).absolute().parent) for path in workflow.overwrite_configfiles)
    os.environ[AGENTS] = os.pathsep.join(beside)
    sys.path.extend(place for place in beside if place not in sys.path)
    provenance.remember(Path.cwd() / SOURCES)
    limit_gpu(workflow)
    if workflow.is_main_process:
        check_writable(Path.cwd(), () if workflow.dryrun else WRITTEN)
        release_stale_locks(Path.cwd())


def check_writable(directory: Path, folders: Sequence[str]) -> None:
    """SystemExit, in one line, where a working directory or one of its `folders` cannot be written."""
    for place in (directory, directory / ".snakemake", *(directory / folder for folder in folders)):
        if place.exists() and not os.access(place, os.W_OK):
            remedy = "make it writable for this user, or work elsewhere with --directory"
            raise SystemExit(f"{place}: is read-only; {remedy}")


def limit_gpu(workflow: Any) -> None:
    """At most one job of those that ask for `gpu` at a time. A user's --resources replaces a profile's limit, but not this."""
    from snakemake.resources import Resource

    workflow.global_resources["gpu"] = Resource("gpu", 1)


def lift_rate_limit(workflow: Any) -> None:
    """As many jobs a second as there are cores for, where jobs are processes of this machine; when the jobs start.

    For the sake of its limit Snakemake looks for work again a second after it has, whatever made it look. While jobs wait for a
    core, every job that ends adds one look a second, and some hundred of them take half a core.
    """
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None


def release_stale_locks(directory: Path) -> None:
    """Remove Snakemake's locks on `directory` if those who took them are dead, and say from now on that this process is alive.

    A Snakemake that was killed leaves its locks, and the next one would refuse to start.
    """
    path = directory / ALIVE
    path.parent.mkdir(parents=True, exist_ok=True)
    file = path.open("a")
    _kept.append(file)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        pass
    else:
        at_work.dead(directory)
        for lock in (directory / ".snakemake" / "locks").glob("*.lock"):
            lock.unlink(missing_ok=True)
    fcntl.flock(file, fcntl.LOCK_SH)


def print_deaths() -> None:
    """Say in one line which job's process ended without a word, and with which arm and episode; for `onerror`."""
    for line in at_work.dead(Path.cwd()):
        print(line, file=sys.stderr, flush=True)


def check_agents(config: Settings, files: Sequence[str | Path]) -> None:
    """Every arm's "module:function" is there, as far as its source tells: nothing is imported.

    files: that the settings were merged from, later ones winning. ConfigError in one line.
    """
    for name, entry in config.arms.items():
        wrong = _lacking(*entry.agent.split(":", 1))
        if wrong is not None:
            file = file_with(files, ("arms", name, "agent"))
            raise ConfigError(f"{file}: arms.{name}.agent is {entry.agent!r}, and {wrong}")


def _lacking(module: str, function: str) -> str | None:
    """What is wrong with an agent, and the remedy; None where it is there."""
    path = provenance.module_file(module)
    if path is None:
        return f"there is no module {module}; install it, or put it beside the overlay"
    try:
        names = provenance.defined(path.read_bytes())
    except SyntaxError as error:
        return f"{path.name}, line {error.lineno}, is no Python: {error.msg}; mend it"
    if names is not None and function not in names:
        return f"{module} has no function {function}; name one that it has"
    return None
