"""What every job of the workflow is doing, so that the death of its process names the arm and the episode.

A job keeps a small file while it runs. A process that is killed, or that an agent ends, cannot say so itself: Snakemake's own
process reads the file afterwards (`dead`). Imports nothing heavy.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from ovman.processes import HOST, alive

FOLDER = Path(".snakemake", "ovman.at_work")
"""One file a job that runs, named by its machine and the id of its process, in the working directory."""


@dataclass
class _Current:
    """The file of this process and what it says; no file outside a workflow."""

    path: Path | None = None
    rule: str = ""
    log: str = ""
    doing: str = ""


_current = _Current()


@contextmanager
def job_at_work(rule: str, log: str) -> Iterator[None]:
    """This process runs a job of `rule` whose log is the file `log`; forgotten at the end, however the block ends."""
    _current.path, _current.rule, _current.log = FOLDER.absolute() / f"{HOST}.{os.getpid()}", rule, log
    _current.path.parent.mkdir(parents=True, exist_ok=True)
    try:
        note("")
        yield
    finally:
        _current.path.unlink(missing_ok=True)
        _current.path = None


def note(doing: str) -> None:
    """Say what this process does from now on, in words that name the arm and the episode. Nothing outside a job."""
    if _current.path is None or (doing == _current.doing and doing):
        return
    _current.doing = doing
    with suppress(OSError):  # a full disk is the job's to complain of
        _current.path.write_text(json.dumps({"rule": _current.rule, "log": _current.log, "doing": doing}))


def dead(directory: Path) -> list[str]:
    """One line about every job in a working directory whose process ended without finishing the job; they are forgotten.

    Processes of other machines cannot be seen. They are taken for dead: Snakemake asks when its jobs have ended.
    """
    lines = []
    for path in sorted((directory / FOLDER).glob("*")):
        host, _, process = path.name.rpartition(".")
        if host == HOST and alive(int(process)):
            continue
        with suppress(OSError, ValueError, KeyError):
            found = json.loads(path.read_text())
            doing = f" during {found['doing']}" if found["doing"] else ""
            cause = "killed, out of memory, or ended by the agent"
            lines.append(f"rule {found['rule']}: the process ended{doing} ({cause}); {found['log']} has what it printed")
        path.unlink(missing_ok=True)
    return lines
