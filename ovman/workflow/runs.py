"""Which run of the workflow a job of a cluster belongs to, so that jobs whose Snakemake was killed do nothing to a later run.

Jobs on this machine end with their Snakemake. Those that were handed to a cluster do not: they wait in its queue, and one that
begins late would remove the outputs that the next run has made meanwhile. So every run has a name of its own, which a file holds
and the jobs inherit; the Snakemake that runs a job on its machine ends once the file holds another. Imports nothing heavy.
"""

from __future__ import annotations

import os
import sys
import threading
import time
import uuid
from pathlib import Path

from ovman.atomic import replace_bytes

RUN = "OVMAN_RUN"
"""Environment variable with the name of the run; clusters hand it on to the jobs."""
FOLLOWED = "OVMAN_RUN_FOLLOWED"
"""Environment variable that says that a process above this one follows the run: its end is the end of this one."""
FILE = Path(".snakemake", "ovman.run")
"""In the working directory: the name of the latest run."""
POLL_S = 5.0


def begin(directory: Path) -> None:
    """Make this process the run of `directory`; the jobs of those before it end."""
    os.environ.pop(FOLLOWED, None)
    os.environ[RUN] = uuid.uuid4().hex
    replace_bytes(directory / FILE, os.environ[RUN].encode())


def follow(directory: Path, poll_s: float = POLL_S) -> None:
    """End this process, now or later, once `directory` has another run than the one that it belongs to.

    It ends without a word to Snakemake, which would remove the outputs of a job that failed. Nothing for a job of no named run.
    """
    run = os.environ.get(RUN)
    if run is None or os.environ.get(FOLLOWED) is not None:
        return
    os.environ[FOLLOWED] = str(os.getpid())
    _end_unless(directory, run)

    def watch() -> None:
        while True:
            time.sleep(poll_s)
            _end_unless(directory, run)

    threading.Thread(target=watch, name="end-with-run", daemon=True).start()


def _end_unless(directory: Path, run: str) -> None:
    try:
        latest = (directory / FILE).read_text()
    except OSError:  # a file system that does not answer is no other run
        return
    if latest != run:
        print(f"{directory}: a later run has taken over; this job does nothing more", file=sys.stderr, flush=True)
        os._exit(1)
