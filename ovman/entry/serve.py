"""`ovman serve`: the server of an agent that is written against `ovman.agents.interface`."""

from __future__ import annotations

import argparse
import os
import signal
import socket
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from ovman.entry import CONFIG, EntryError
from ovman.entry.entrant import select_arm
from ovman.evaluation.supervision import AgentError
from ovman.remote.host import host_arm
from ovman.settings.config import load
from ovman_client import Server


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `ovman serve`."""
    who = parser.add_mutually_exclusive_group(required=True)
    who.add_argument("--agent", metavar="MODULE:FUNCTION", help="what makes the agent (docs/agents.md)")
    who.add_argument("--arm", metavar="NAME", help="an embodied arm of config.yaml")
    parser.add_argument("--needs", nargs="*", metavar="NEED", help="of an --agent: tours (the default), maps, detections ...")
    parser.add_argument("--name", metavar="NAME", help="what the agent is called; default: its module's last name, or the arm's")
    parser.add_argument("--host", default="127.0.0.1", help="where to listen; 0.0.0.0 for other machines. Default: 127.0.0.1")
    parser.add_argument("--port", type=int, default=8765, help="0 takes a free one. Default: 8765")
    parser.add_argument("--config", metavar="FILE", help="default: that of the checkout")
    parser.add_argument("--path", metavar="DIR", default=".", help="where the agent's module lies; default: this directory")
    parser.add_argument("--listener", type=int, metavar="FD", help=argparse.SUPPRESS)
    parser.add_argument("--ready", type=int, metavar="FD", help=argparse.SUPPRESS)


def serve(options: argparse.Namespace) -> None:
    """Serve until the process is told to end. ConfigError, EntryError, AgentError, in one line."""
    sys.path.insert(0, str(Path(options.path).absolute()))
    settings, name = select_arm(load(Path(options.config or CONFIG)), options.agent, options.arm, options.name, options.needs)
    make = host_arm(settings, name)
    listener = None if options.listener is None else socket.socket(fileno=options.listener)
    try:
        server = Server(make, name, options.host, options.port, decoded=False, listener=listener)
    except (OSError, OverflowError) as error:
        where = f"--host {options.host} --port {options.port}"
        raise EntryError(f"{where}: {error}; write another port, or 0 for a free one") from None
    if options.ready is None:
        print(server.greeting, file=sys.stderr, flush=True)
    else:
        _belong_to_evaluator()
        os.write(options.ready, b"ready\n")
        os.close(options.ready)
    server.forever()


def _belong_to_evaluator() -> None:
    """End all of this session when the evaluator closes standard input."""
    evaluator = os.dup(sys.stdin.fileno())

    def end_with_evaluator() -> None:
        os.read(evaluator, 1)
        os.killpg(0, signal.SIGKILL)

    threading.Thread(target=end_with_evaluator, daemon=True).start()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return the exit status."""
    parser = argparse.ArgumentParser(prog="ovman serve", allow_abbrev=False)
    add_arguments(parser)
    try:
        serve(parser.parse_args(arguments))
    except (ValueError, OSError, AgentError) as error:
        print(f"ovman serve: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
