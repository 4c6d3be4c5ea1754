"""Engines as forks of the test process, which has loaded what they need: the imports of one take 0.3 s."""

from __future__ import annotations

import contextlib
import gc
import json
import os
import shlex
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import IO, Any, NoReturn

from ovman_engine import executable

LOOK_S = 0.005
SIDE_PX = 48


class ForkedEngine:
    """An engine's process, with what the client uses of `subprocess.Popen`. May be waited for by several threads."""

    def __init__(self, options: Sequence[str], environment: Mapping[str, str], output: IO[Any]) -> None:
        """Fork this process. options: of the engine's command line; output: where it prints to."""
        self.returncode: int | None = None
        self._lock = threading.Lock()
        self.pid = os.fork()
        if self.pid == 0:
            _become(options, environment, output)

    def poll(self) -> int | None:
        """Return the exit status, negative for a signal; None while it runs."""
        with self._lock:
            if self.returncode is None:
                pid, status = os.waitpid(self.pid, os.WNOHANG)
                if pid:
                    self.returncode = os.waitstatus_to_exitcode(status)
            return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Return the exit status, once it has ended; subprocess.TimeoutExpired after so many seconds."""
        begun = time.monotonic()
        while (status := self.poll()) is None:
            if timeout is not None and time.monotonic() - begun > timeout:
                raise subprocess.TimeoutExpired("ovman_engine", timeout)
            time.sleep(LOOK_S)
        return status

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


def warm(client: ModuleType) -> None:
    """Load what an engine needs, once, and have the module `ai2thor.controller` fork engines in this process."""
    if isinstance(client.subprocess, _Subprocess):
        return
    from ovman_engine.engine import Engine

    engine = Engine(SIDE_PX, SIDE_PX)
    for action, arguments in (
        ("Reset", {"sceneName": "FloorPlan212_physics"}),
        ("Initialize", {"renderDepthImage": True, "renderInstanceSegmentation": True}),
        ("RotateRight", {}),
    ):
        engine.answer(json.dumps({"action": action, **arguments}).encode())
    client.subprocess = _Subprocess("subprocess")  # type: ignore[attr-defined]


class _Subprocess(ModuleType):
    """The module `subprocess` for the client: what it starts as this package's engine is forked."""

    def __getattr__(self, name: str) -> Any:
        return getattr(subprocess, name)

    @staticmethod
    def Popen(command: Sequence[str], env: Mapping[str, str], stdout: IO[Any], stderr: IO[Any]) -> Any:  # noqa: N802
        own = shlex.split(executable())
        if [*command[: len(own)]] != own or own[0] != sys.executable:
            return subprocess.Popen(command, env=env, stdout=stdout, stderr=stderr)
        return ForkedEngine(command[len(own) :], env, stderr)


def _become(options: Sequence[str], environment: Mapping[str, str], output: IO[Any]) -> NoReturn:
    """Be the process that the command line would start."""
    status = 1
    try:
        gc.freeze()  # going through what the driving process holds would copy all of it
        for stream in (1, 2):
            os.dup2(output.fileno(), stream)
        os.closerange(3, os.sysconf("SC_OPEN_MAX"))  # a lock that the driving process holds is not the engine's
        for number in (signal.SIGCHLD, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        with contextlib.suppress(OSError):
            Path("/proc/self/comm").write_text("ovman_engine")  # what `ps` and `top` call it
        os.environ.clear()
        os.environ.update(environment)
        from ovman_engine.__main__ import main

        status = main(options)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(status)
