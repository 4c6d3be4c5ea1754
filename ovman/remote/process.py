"""An agent in a process of its own on this machine: empty folders, few variables, and an end with the evaluator."""

from __future__ import annotations

import os
import secrets
import select
import shutil
import signal
import site
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from ovman.evaluation.supervision import AgentError
from ovman.remote.connection import ConnectionLost
from ovman.shipped import user_cache
from ovman_client.server import TOKEN

PASSED = ("PATH", "PYTHONPATH", "PYTHONNOUSERSITE", "LANG", "VIRTUAL_ENV", "LD_LIBRARY_PATH")
"""Variables of the evaluator's that the process has, and those that begin with `PASSED_BEGINNINGS`."""
PASSED_BEGINNINGS = ("LC_", "OMP_", "OPENBLAS_", "MKL_", "NUMBA_", "CUDA_", "NVIDIA_", "ORT_")
TAIL = 2000
"""Bytes of the log in which the last line is looked for."""


class AgentProcess:
    """A server of an agent that the evaluator starts, `ovman.entry.serve`. url: Where it listens."""

    def __init__(self, arguments: Sequence[str], connect_s: float, log: Path) -> None:
        """Start the process and wait until it listens.

        Args:
            arguments: Of Python, for a server that takes a port (0 for a free one) and the number of a file for the port. It ends
                with its session when its standard input closes, however the evaluator ended.
            connect_s: Seconds until it must listen.
            log: File that takes the output of the agent.

        Raises:
            ConnectionLost: The process ends before it listens.
            AgentError: The process does not listen in time.
        """
        self._folder = Path(tempfile.mkdtemp(prefix="ovman-agent-"))
        work, home, temporary = (self._folder / name for name in ("work", "home", "tmp"))
        for place in (work, home, temporary):
            place.mkdir()
        user = {"XDG_CACHE_HOME": str(user_cache().parent), "PYTHONUSERBASE": site.getuserbase()}
        token = secrets.token_urlsafe(16)
        reading, writing = os.pipe()
        with log.open("ab") as output:
            self._process = subprocess.Popen(
                [sys.executable, *arguments, "--port", "0", "--ready", str(writing)],
                cwd=work,
                env={**passed_variables(os.environ), **user, "HOME": str(home), "TMPDIR": str(temporary), TOKEN: token},
                stdin=subprocess.PIPE,
                stdout=output,
                stderr=output,
                pass_fds=[writing],
                start_new_session=True,
            )
        os.close(writing)
        listens, _, _ = select.select([reading], [], [], connect_s)
        port = os.read(reading, 64) if listens else b""
        os.close(reading)
        if not port:
            self.end()
            if not listens:
                raise AgentError(f"the agent did not listen within {connect_s:g} s; raise remote.connect_s")
            said = log.read_bytes()[-TAIL:].decode("utf-8", "replace").strip().splitlines() or ["it said nothing"]
            raise ConnectionLost(f"the agent's process ended before it listened: {said[-1]}")
        self.url = f"ws://127.0.0.1:{int(port)}/?token={token}"

    def end(self) -> None:
        """End the process with those that it started in its session, and remove its folders."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.communicate()
        shutil.rmtree(self._folder, ignore_errors=True)


def passed_variables(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the variables of the evaluator that an agent's process has."""
    return {name: value for name, value in environment.items() if name in PASSED or name.startswith(PASSED_BEGINNINGS)}
