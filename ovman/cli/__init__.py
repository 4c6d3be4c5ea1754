"""The command `ovman`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from ovman import __version__, kernels
from ovman.cli import entries, results


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit status: 0 if all is well, 1 if something that was asked for is not, 2 for a wrong command."""
    kernels.hold()
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given[:1] == ["serve"]:  # its own parser says what is served: the module that has it loads the networks' side
        from ovman.entry.serve import main as serve

        return serve(given[1:])
    parser = argparse.ArgumentParser(prog="ovman", description="Open-vocabulary motion-aware navigation.")
    parser.add_argument("--version", action="version", version=f"ovman {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="command")
    for room in (results, entries):
        room.add(commands)
    options = parser.parse_args(given)
    status: int = options.run(options)
    return status
