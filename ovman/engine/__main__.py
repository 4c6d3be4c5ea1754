"""The engine's process: `python -m ovman.engine`, started by the ai2thor Controller and driven over its FIFO protocol."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence

from ovman.engine.wire import ClientGone, Wire

SERVER_PIPE, CLIENT_PIPE = "AI2THOR_FIFO_SERVER_PIPE_PATH", "AI2THOR_FIFO_CLIENT_PIPE_PATH"


def main(arguments: Sequence[str] | None = None) -> int:
    """Serves one client until it goes. Returns the exit status: 0, or 2 if nobody started it as an engine.

    The options are those that the Controller gives a Unity player: -screen-width and -screen-height are heeded.
    """
    options = list(sys.argv[1:] if arguments is None else arguments)
    if SERVER_PIPE not in os.environ or CLIENT_PIPE not in os.environ:
        print(
            "ovman-engine is started by the ai2thor Controller: Controller(local_executable_path=ovman.engine.executable()). "
            f"The variables {SERVER_PIPE} and {CLIENT_PIPE} name no pipes.",
            file=sys.stderr,
        )
        return 2
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")  # small matrices: threads only wait for each other
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for the client in the same terminal; the engine ends when its pipe does
    try:
        wire = Wire(os.environ[SERVER_PIPE], os.environ[CLIENT_PIPE])
        _serve(wire, _pixels(options, "-screen-width"), _pixels(options, "-screen-height"))
    except ClientGone as reason:
        print(f"ovman-engine: {reason}", flush=True)
    return 0


def _serve(wire: Wire, width: int, height: int) -> None:
    from ovman.engine.engine import Engine

    draws = os.environ.get("AI2THOR_SERVER_SIDE_SCREENSHOT", "True") != "False"
    engine = Engine(width, height, draws)
    wire.send(engine.first_message())
    while True:
        wire.send(engine.answer(wire.receive()))


def _pixels(options: Sequence[str], name: str, default: int = 300) -> int:
    """Value of an option; the default where it is absent (headless) or no size."""
    try:
        value = int(options[options.index(name) + 1])
    except (ValueError, IndexError):
        return default
    return value if value > 0 else default


if __name__ == "__main__":
    sys.exit(main())
