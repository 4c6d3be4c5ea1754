"""An agent in a process of its own on this machine: empty folders, few variables, and limits that hold for all that it starts."""

from __future__ import annotations

import json
import os
import secrets
import select
import shutil
import site
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from ovman.evaluation.supervision import AgentError
from ovman.remote import supervisor
from ovman.remote.connection import ConnectionLost
from ovman.settings.benchmark import Remote
from ovman.shipped import user_cache
from ovman_client.server import TOKEN

PASSED = ("PATH", "PYTHONPATH", "PYTHONNOUSERSITE", "LANG", "VIRTUAL_ENV", "LD_LIBRARY_PATH")
"""Variables of the evaluator's that the process has, and those that begin with `PASSED_BEGINNINGS`."""
PASSED_BEGINNINGS = ("LC_", "OMP_", "OPENBLAS_", "MKL_", "NUMBA_", "CUDA_", "NVIDIA_", "ORT_")
PLACES = ("work", "home", "tmp")
"""Folders of the agent: its working directory, HOME and TMPDIR. They are emptied before each run."""
TAIL = 2000
"""Bytes of the log in which the last line is looked for."""
ENDING_S = 2 * supervisor.STUBBORN_S


class AgentProcess:
    """A server of an agent that the evaluator starts, and starts again if it died. A context manager."""

    def __init__(self, arguments: Sequence[str], limits: Remote, log: Path) -> None:
        """Prepare the process; it starts at the first `address`.

        Args:
            arguments: Of Python, for a server that takes a port (0 for a free one) and the number of a file for the port.
            limits: Resources of the agent's processes.
            log: File that takes the output of the agent.
        """
        self._arguments, self._limits, self._log = list(arguments), limits, log
        self._process: subprocess.Popen[bytes] | None = None
        self._folder: tuple[Path, int] | None = None
        self._url = ""

    def address(self) -> str:
        """Return where the server listens; start it if it does not run.

        Raises:
            ConnectionLost: The process ends before it listens.
            AgentError: The process does not listen in time.
        """
        if self._process is None or self._process.poll() is not None:
            self.end()
            self._start()
        return self._url

    def __enter__(self) -> AgentProcess:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()

    def clean(self) -> None:
        """Empty the agent's folders, so that a run finds nothing of another run there."""
        if self._folder is not None:
            _, places = self._folder
            _empty(places, PLACES)
            for name in PLACES:
                with suppress(FileExistsError):
                    os.mkdir(name, dir_fd=places)

    def _start(self) -> None:
        path = Path(tempfile.mkdtemp(prefix="ovman-agent-"))
        self._folder = path, os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        self.clean()
        reading, writing = os.pipe()
        token = secrets.token_urlsafe(16)
        limits = {**self._limits.model_dump(), "places": str(path), "ready": writing}
        server = [sys.executable, *self._arguments, "--port", "0", "--ready", str(writing)]
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-S", supervisor.__file__, json.dumps(limits), *server],
                env={**passed_variables(os.environ), **own_variables(path), TOKEN: token},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                pass_fds=[writing],
                start_new_session=True,
            )
        os.close(writing)
        try:
            self._url = f"ws://127.0.0.1:{self._read_port(reading)}/?token={token}"
        finally:
            os.close(reading)

    def _read_port(self, reading: int) -> int:
        until, said = time.monotonic() + self._limits.connect_s, b""
        while not said.endswith(b"\n"):
            ready, _, _ = select.select([reading], [], [], max(0.0, until - time.monotonic()))
            if not ready:
                self.end()
                raise AgentError(f"the agent did not listen within {self._limits.connect_s:g} s; raise remote.connect_s")
            if not (part := os.read(reading, 64)):
                raise ConnectionLost(f"the agent's process ended before it listened: {self.passed_limit() or self._last_line()}")
            said += part
        return int(said)

    def _last_line(self) -> str:
        said = self._log.read_bytes()[-TAIL:].decode("utf-8", "replace").strip().splitlines()
        return said[-1] if said else "it said nothing"

    def passed_limit(self) -> str | None:
        """End the process, and return which limit its processes had passed, None for none."""
        if self._process is None:
            return None
        try:
            said, _ = self._process.communicate(timeout=ENDING_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            said, _ = self._process.communicate()
        self._process = None
        return said.decode().strip() or None

    def end(self) -> None:
        """End the process with all that it started, and remove its folders."""
        self.passed_limit()
        if self._folder is not None:
            path, places = self._folder
            _empty(places)
            os.close(places)
            shutil.rmtree(path, ignore_errors=True)
            self._folder = None


def passed_variables(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the variables of the evaluator that an agent's process has."""
    return {name: value for name, value in environment.items() if name in PASSED or name.startswith(PASSED_BEGINNINGS)}


def own_variables(folder: Path) -> dict[str, str]:
    """Return the variables of a process whose folders lie in `folder`. Caches and packages of the user's stay within reach."""
    user = {"XDG_CACHE_HOME": str(user_cache().parent), "PYTHONUSERBASE": site.getuserbase()}
    return {"HOME": str(folder / "home"), "TMPDIR": str(folder / "tmp"), **user}


def _empty(directory: int, kept: Sequence[str] = ()) -> None:
    """Remove all that is in an open directory. Folders called as in `kept` are emptied and stay; no link is followed."""
    for entry in list(os.scandir(directory)):
        with suppress(OSError):
            if not entry.is_dir(follow_symlinks=False):
                os.unlink(entry.name, dir_fd=directory)
            elif entry.name in kept:
                inner = os.open(entry.name, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=directory)
                try:
                    _empty(inner)
                finally:
                    os.close(inner)
            else:
                shutil.rmtree(entry.name, ignore_errors=True, dir_fd=directory)
