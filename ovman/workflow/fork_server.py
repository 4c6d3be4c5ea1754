"""The process that a workflow's jobs are forked from: what they import is imported once.

A job of a second spends most of it on imports. `python -m ovman.workflow.fork_server` waits for scripts on a socket, imports what
they import, and runs each in a fork of its own, as `python SCRIPT` would. It has one thread and draws no number, so that a fork
is as good as a fresh process. It ends with the process that started it.
"""

from __future__ import annotations

import ast
import atexit
import gc
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from ovman.workflow.sources import imported

ENDING_S = 2.0
"""Time limit for the end of the server after its socket was closed."""
LARGEST = 1 << 20
"""Bytes of a request; an environment is some kilobytes."""
BEFORE = {"ovman", "snakemake", *sys.stdlib_module_names}
"""Packages of which modules are imported before a fork. Nobody knows what a user's or a plug-in's do when they are imported."""
APART = ("ovman.training", "ovman.report", "ovman.doctor", "ovman.analysis")
"""What few jobs import and no other one should wait for. PyTorch and what pandas imports begin threads, too."""


class Fork:
    """A script that runs in a process of its own. processor_s: what it and its children took, once it was waited for."""

    def __init__(self, reply: socket.socket) -> None:
        self._reply = reply
        self.pid = int(self._line())
        self.processor_s: float | None = None

    def wait(self) -> int:
        """The exit status, negative for a signal as in `subprocess`, once the process has ended."""
        with self._reply:
            status, processor_s = self._line().split()
        self.processor_s = float(processor_s)
        return int(status)

    def _line(self) -> str:
        said = self._reply.recv(LARGEST)
        if not said:
            raise ChildProcessError("the process that jobs are forked from has ended")
        return said.decode()


class ForkServer:
    """Starts its process at the first script. May be used by several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._requests: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None

    def run(self, script: str | Path, environment: Mapping[str, str]) -> Fork:
        """`python SCRIPT` in this process's directory with these variables, in a fork. ChildProcessError if the server ended."""
        reply, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        asked = json.dumps({"script": str(script), "directory": str(Path.cwd()), "environment": dict(environment)}).encode()
        with theirs, self._lock:
            if self._requests is None:
                self._requests = self._start()
            try:
                socket.send_fds(self._requests, [asked], [theirs.fileno()])
            except OSError as error:
                raise ChildProcessError(f"the process that jobs are forked from has ended: {error}") from None
        return Fork(reply)

    def end(self) -> None:
        """Let the server end, and wait for it: what its forks took is then part of what this process's children took."""
        if self._requests is not None and self._process is not None:
            self._requests.close()
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(ENDING_S)

    def _start(self) -> socket.socket:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, LARGEST)
        with theirs:
            # -P: a module in the working directory replaces no other.
            command = [sys.executable, "-P", "-m", "ovman.workflow.fork_server", str(theirs.fileno())]
            self._process = subprocess.Popen(command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL)
        atexit.register(self.end)
        return ours


def _load(script: Path) -> None:
    """Import what a script imports, so that no later one has to. What cannot be imported is the script's to report."""
    for name, _ in imported(ast.parse(script.read_bytes())):  # a script has no relative imports
        if name.partition(".")[0] not in BEFORE or name.startswith(APART):
            continue
        with suppress(Exception, SystemExit):
            if find_spec(name) is not None:  # a name that a script imports from a module may be no module
                import_module(name)
    # What these import only when they first drive or see something.
    if "ovman.sim.client" in sys.modules:
        sys.modules["ovman.sim.client"].controller()
        import_module("ovman_engine.forked").warm(sys.modules["ai2thor.controller"])
    if "ovman.perception.graph" in sys.modules:
        import_module("onnxruntime")


def _serve(requests: socket.socket) -> str:
    """Answer requests; returns only in a fork, with the script that it is to run. SystemExit where nobody can ask any more."""
    replies: dict[int, socket.socket] = {}
    woken, wake = os.pipe()
    os.set_blocking(wake, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wake)
    while True:
        ready, _, _ = select.select([requests.fileno(), woken], [], [])
        if woken in ready:
            os.read(woken, LARGEST)
            for pid, status, processor_s in _ended():
                with replies.pop(pid) as reply, suppress(OSError):  # nobody may wait for it any more
                    reply.send(f"{status} {processor_s}".encode())
        if requests.fileno() not in ready:
            continue
        asked, fds, _, _ = socket.recv_fds(requests, LARGEST, 1)
        if not asked:
            raise SystemExit
        wanted, reply = json.loads(asked), socket.socket(fileno=fds[0])
        _load(Path(wanted["directory"], wanted["script"]))
        gc.freeze()  # what is imported stays; going through it would copy it in every fork
        pid = os.fork()
        if pid == 0:
            signal.set_wakeup_fd(-1)
            for descriptor in (woken, wake):
                os.close(descriptor)
            for one in (requests, reply, *replies.values()):
                one.close()
            _become(Path(wanted["script"]), wanted["directory"], wanted["environment"])
            return str(wanted["script"])
        replies[pid] = reply
        with suppress(OSError):
            reply.send(str(pid).encode())


def _become(script: Path, directory: str, environment: Mapping[str, str]) -> None:
    with suppress(OSError):  # what `ps` and `top` call it: of Snakemake's tmpabc.rollouts.py, rollouts
        Path("/proc/self/comm").write_text(script.stem.rpartition(".")[2])
    for number in (signal.SIGCHLD, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(directory)


def _ended() -> list[tuple[int, int, float]]:
    """Processes that have ended, their exit statuses, and the seconds of the processor that they and their children took."""
    found = []
    with suppress(ChildProcessError):
        while (ended := os.wait4(-1, os.WNOHANG))[0]:
            pid, status, usage = ended
            found.append((pid, os.waitstatus_to_exitcode(status), round(usage.ru_utime + usage.ru_stime, 3)))
    return found


def main() -> None:
    """Serve on the socket whose number is the first argument; in a fork, be `python SCRIPT`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the workflow's to answer: it waits for its jobs
    script = _serve(socket.socket(fileno=int(sys.argv[1])))
    sys.argv = [script]
    sys.path.insert(0, str(Path(script).parent))
    runpy.run_path(script, run_name="__main__")


if __name__ == "__main__":
    main()
