"""The engine's process: `python -m ovman_engine`, started by the ai2thor Controller and driven over its FIFO protocol."""

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
"""How often the engine looks whether the process that started it still lives."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Serves one client until it goes. Returns the exit status: 0, or 2 if nobody started it as an engine.

    The options are those that the Controller gives a Unity player: -screen-width and -screen-height are heeded.
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
        os.environ.setdefault(variable, "1")  # small matrices: threads only wait for each other
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for the client in the same terminal; the engine ends when its pipe does
    parent = os.getppid()
    try:
        wire = Wire(os.environ[SERVER_PIPE], os.environ[CLIENT_PIPE])
        _end_with(parent)
        _serve(wire, *_size(options))
    except ClientGone as reason:
        log.note(f"ovman-engine: {reason}")
    return 0


def _serve(wire: Wire, width: int, height: int) -> None:
    from ovman_engine import kernels
    from ovman_engine.engine import Engine

    draws = os.environ.get("AI2THOR_SERVER_SIDE_SCREENSHOT", "True") != "False"
    if draws and not kernels.ready():
        log.note("ovman-engine: compiling what draws, which happens once on a machine and takes about half a minute")
        kernels.compile_all()
    engine = Engine(width, height, draws)
    wire.send(engine.first_message())
    while True:
        wire.send(engine.answer(wire.receive()))


def _size(options: Sequence[str]) -> tuple[int, int]:
    """Width and height that the options ask for. The default where there are none (headless), or none that pictures can have: the
    client then asks for its size by an action, which can be refused with a reason."""
    width, height = (_pixels(options, name) for name in ("-screen-width", "-screen-height"))
    return DEFAULT_SIZE if objection(width, height) else (width, height)


def _pixels(options: Sequence[str], name: str) -> int:
    try:
        return int(options[options.index(name) + 1])
    except (ValueError, IndexError):
        return 0


def _end_with(parent: int) -> None:
    """Ends this process soon after the process `parent` has, whatever it is doing then: drawing, or writing to a pipe that a fork
    of the client holds open. Not by the kernel's signal, which follows the thread that started the engine, not its process."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(WATCH_S)
        os._exit(0)

    threading.Thread(target=watch, name="end-with-client", daemon=True).start()


if __name__ == "__main__":
    sys.exit(main())
