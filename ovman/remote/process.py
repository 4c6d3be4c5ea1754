"""An agent in a process of its own on this machine: an empty directory, few variables, and limits of memory and of files."""

from __future__ import annotations

import ctypes
import os
import resource
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from ovman.evaluation.supervision import AgentError
from ovman.models.settings.remote import Remote
from ovman.remote.line import LineLost

PASSED = ("PATH", "PYTHONPATH", "PYTHONNOUSERSITE", "HOME", "LANG", "TMPDIR", "VIRTUAL_ENV", "LD_LIBRARY_PATH", "XDG_CACHE_HOME")
"""Variables of the evaluator's that the process has, and those that begin with `PASSED_BEGINNINGS`."""
PASSED_BEGINNINGS = ("LC_", "OMP_", "OPENBLAS_", "MKL_", "NUMBA_", "CUDA_", "NVIDIA_", "ORT_")
GB = 10**9
PR_SET_PDEATHSIG = 1
"""Linux's number for: end this process when the one that started it ends."""
TAIL = 2000
"""Bytes of the log in which the last line is looked for."""


class AgentProcess:
    """Starts the server of an agent, and again where it died. A context manager.

    arguments: of Python, to a server that takes a port (0 for a free one) and the number of a file that it writes the port to.
    log: file that takes what the agent prints.
    """

    def __init__(self, arguments: Sequence[str], limits: Remote, log: Path) -> None:
        self._arguments, self._limits, self._log = list(arguments), limits, log
        self._process: subprocess.Popen[bytes] | None = None
        self._home: str | None = None
        self._port = 0

    def address(self) -> str:
        """Where it listens; it is started where it does not run. LineLost where it ends before it listens, AgentError where it
        does not begin to in time."""
        if self._process is None or self._process.poll() is not None:
            self.end()
            self._start()
        return f"ws://127.0.0.1:{self._port}"

    def __enter__(self) -> AgentProcess:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()

    def _start(self) -> None:
        self._home = tempfile.mkdtemp(prefix="ovman-agent-")
        reading, writing = os.pipe()
        command = [sys.executable, *self._arguments, "--port", "0", "--ready", str(writing)]
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(
                command,
                cwd=self._home,
                env=passed(os.environ),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                pass_fds=[writing],
                start_new_session=True,
                preexec_fn=self._limited,
            )
        os.close(writing)
        try:
            self._port = self._announced(reading)
        finally:
            os.close(reading)

    def _announced(self, reading: int) -> int:
        until, said = time.monotonic() + self._limits.connect_s, b""
        while not said.endswith(b"\n"):
            ready, _, _ = select.select([reading], [], [], max(0.0, until - time.monotonic()))
            if not ready:
                self.end()
                raise AgentError(f"the agent did not listen within {self._limits.connect_s:g} s; raise remote.connect_s")
            if not (part := os.read(reading, 64)):
                raise LineLost(f"the agent's process ended before it listened: {self._last_line()}")
            said += part
        return int(said)

    def _limited(self) -> None:
        memory, file = (int(size * GB) for size in (self._limits.memory_gb, self._limits.file_gb))
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
        resource.setrlimit(resource.RLIMIT_FSIZE, (file, file))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)  # an evaluator that is killed cannot end it

    def _last_line(self) -> str:
        said = self._log.read_bytes()[-TAIL:].decode("utf-8", "replace").strip().splitlines()
        return said[-1] if said else "it said nothing"

    def end(self) -> None:
        """End it, where it runs, with all that it started."""
        if self._process is not None:
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
            self._process = None
        if self._home is not None:
            shutil.rmtree(self._home, ignore_errors=True)
            self._home = None


def passed(environment: Mapping[str, str]) -> dict[str, str]:
    """What an agent's process has of the variables of the evaluator's."""
    return {name: value for name, value in environment.items() if name in PASSED or name.startswith(PASSED_BEGINNINGS)}
