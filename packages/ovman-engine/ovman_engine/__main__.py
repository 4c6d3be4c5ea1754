"""The engine's process, `python -m ovman_engine`: the ai2thor Controller starts it and drives it over its FIFO protocol."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Sequence

from ovman_engine.client import log
from ovman_engine.client.resolution import objection
from ovman_engine.client.wire import ClientGone, Wire

SERVER_PIPE, CLIENT_PIPE = "AI2THOR_FIFO_SERVER_PIPE_PATH", "AI2THOR_FIFO_CLIENT_PIPE_PATH"
DEFAULT_SIZE = 300, 300
WATCH_S = 0.5
"""Interval at which the engine checks that the process that started it is alive."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve one client until it stops. Returns the exit status: 0, or 2 if the environment names no pipes.

    The options are those of a Unity player; -screen-width and -screen-height are used.
    """
    options = list(sys.argv[1:] if arguments is None else arguments)
    if SERVER_PIPE not in os.environ or CLIENT_PIPE not in os.environ:
        print(
            "ovman-engine is started by the ai2thor Controller: Controller(local_executable_path=ovman_engine.executable()). "
            f"The variables {SERVER_PIPE} and {CLIENT_PIPE} name no pipes.",
            file=sys.stderr,
        )
        return 2
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")  # the matrices are small: threads would only wait for each other
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is meant for the client; the engine ends with its pipe
    parent = os.getppid()
    try:
        wire = Wire(os.environ[SERVER_PIPE], os.environ[CLIENT_PIPE])
        _end_with(parent)
        _serve(wire, *_size(options))
    except ClientGone as reason:
        log.note(f"ovman-engine: {reason}")
    return 0


def _serve(wire: Wire, width: int, height: int) -> None:
    from ovman_engine.engine import Engine

    draws = os.environ.get("AI2THOR_SERVER_SIDE_SCREENSHOT", "True") != "False"
    engine = Engine(width, height, draws)
    wire.send(engine.first_message())
    while True:
        request = wire.receive()
        wire.send(engine.answer(request))


def _size(options: Sequence[str]) -> tuple[int, int]:
    """Width and height from the options.

    The default if they are missing (headless) or impossible: the client then asks for its size with ChangeResolution, which can
    be refused with a reason.
    """
    width, height = (_pixels(options, name) for name in ("-screen-width", "-screen-height"))
    return DEFAULT_SIZE if objection(width, height) else (width, height)


def _pixels(options: Sequence[str], name: str) -> int:
    try:
        return int(options[options.index(name) + 1])
    except (ValueError, IndexError):
        return 0


def _end_with(parent: int) -> None:
    """End this process soon after the process `parent` has ended.

    This holds while it draws or writes to a pipe that a fork of the client holds open. The kernel's parent-death signal would
    follow the thread that started the engine, not its process.
    """

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(WATCH_S)
        os._exit(0)

    threading.Thread(target=watch, name="end-with-client", daemon=True).start()


if __name__ == "__main__":
    sys.exit(main())
