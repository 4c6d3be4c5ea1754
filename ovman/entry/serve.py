"""`ovman serve`: the server of an agent that is written against `ovman.agents.interface`."""

from __future__ import annotations

import argparse
import os
import signal
import socket
import sys
import threading

from ovman.entry import EntryError
from ovman.entry.entrant import select_arm
from ovman.remote.host import host_arm
from ovman.settings.config import load
from ovman_client import Server


def serve_agent(options: argparse.Namespace) -> None:
    """Serve an agent until the process is told to end. ConfigError, EntryError, AgentError, in one line."""
    if options.agent is None and options.arm is None:
        raise EntryError("name the agent: --agent MODULE:FUNCTION or --arm NAME")
    sys.path.insert(0, str(options.path.absolute()))
    settings, name = select_arm(load(options.config), options.agent, options.arm, options.name, options.needs)
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
