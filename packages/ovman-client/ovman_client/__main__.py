"""`python -m ovman_client module:Class`: serve an agent to the evaluator."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from ovman_client.server import lacking, serve


def main(arguments: Sequence[str] | None = None) -> int:
    """Return the exit status: 1 where there is no such agent."""
    parser = argparse.ArgumentParser(prog="ovman-client", description="Serve an agent to OVMAN's evaluator.")
    parser.add_argument("agent", metavar="MODULE:CLASS", help="what makes the agent; the module may lie in this directory")
    parser.add_argument("--host", default="127.0.0.1", help="where to listen; 0.0.0.0 for other machines. Default: 127.0.0.1")
    parser.add_argument("--port", type=int, default=8765, help="default: 8765")
    parser.add_argument("--name", help="what the agent is called; default: the name of its class")
    options = parser.parse_args(arguments)
    sys.path.insert(0, "")
    module, _, attribute = options.agent.partition(":")
    if module.endswith(".py"):
        print(f"ovman-client: {options.agent} names a file; write {Path(module).stem}:{attribute}", file=sys.stderr)
        return 1
    try:
        agent = getattr(import_module(module), attribute)
    except (ImportError, AttributeError, ValueError, SyntaxError) as error:
        print(f"ovman-client: {options.agent}: {error}; write module:Class", file=sys.stderr)
        return 1
    if (absent := lacking(agent)) is not None:
        print(f"ovman-client: {options.agent} has no method {absent}; write it (docs/protocol.md)", file=sys.stderr)
        return 1
    try:
        serve(agent, options.name, options.host, options.port)
    except (OSError, OverflowError) as error:
        print(f"ovman-client: --port {options.port}: {error}; write another, or 0 for a free one", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
