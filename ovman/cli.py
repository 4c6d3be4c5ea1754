"""The command `ovman`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from ovman import __version__


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit status: 0 if all is well, 1 if something that was asked for is not, 2 for a wrong command."""
    parser = argparse.ArgumentParser(prog="ovman", description="Open-vocabulary motion-aware navigation.")
    parser.add_argument("--version", action="version", version=f"ovman {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="command")
    doctor = commands.add_parser("doctor", help="what works on this machine, and what to do about what does not")
    doctor.add_argument("--thor", action="store_true", help="look at Vulkan and AI2-THOR's Unity build, too")
    options = parser.parse_args(arguments)
    return _doctor(options.thor)


def _doctor(thor: bool) -> int:
    from ovman.doctor.checks import State, findings, report

    well = True
    for found in findings(thor):
        print(report([found]), flush=True)
        well &= found.state is not State.ILL
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main())
