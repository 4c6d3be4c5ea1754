"""The command `ovman`."""

from __future__ import annotations

import argparse
import difflib
import re
import sys
from collections.abc import Iterable, Sequence
from itertools import takewhile

from ovman import __version__, kernels
from ovman.cli.commands import Parser, add_commands

EXTRAS = {"gymnasium": "gym", "py_ecc": "beacon", "pyarrow": "dataset"}
"""The extra that brings a module; without one the benchmark itself requires it."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Return the exit status: 0 for success, 1 if something that was asked for failed, 2 for a wrong command."""
    kernels.hold()
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given[:1] == ["serve"]:  # its own parser says what is served: the module that has it loads the networks' side
        from ovman.entry.serve import main as serve

        return serve(given[1:])
    parser = Parser(prog="ovman", description="Open-vocabulary motion-aware navigation.")
    parser.add_argument("--version", action="version", version=f"ovman {__version__}")
    commands = add_commands(parser)
    if not given:
        parser.print_help()
        return 0
    if given[0].startswith("-"):
        _refuse_unknown_options(parser, given)
        parser.parse_args(given)
        parser.error("name a command; ovman --help lists all")
    if given[0] not in commands:
        parser.error(f"no such command: {given[0]}{_nearest(given[0], commands) or '; ovman --help lists all'}")
    chosen = commands[given[0]]
    _refuse_unknown_options(chosen, given)
    return _run(given[0], chosen.parse_args(given[1:]))


def _run(command: str, options: argparse.Namespace) -> int:
    """Return the exit status of a command; print one line instead of a traceback if it fails."""
    try:
        status: int = options.run(options)
    except ModuleNotFoundError as missing:
        if (missing.name or "").split(".")[0] == "ovman":
            raise
        extra = EXTRAS.get(missing.name or "")
        install = "pip install ." if extra is None else f"pip install '.[{extra}]'"
        return _fail(command, f"{missing.name} is not installed; in a checkout of OVMAN: {install}")
    except KeyboardInterrupt:
        print(f"ovman {command}: {options.interrupted.format(**vars(options))}", file=sys.stderr)
        return 130
    except (ValueError, OSError) as error:
        return _fail(command, str(error))
    except Exception as error:
        from ovman.evaluation.supervision import AgentError  # slow, and most commands start no simulator
        from ovman.sim.session import SimulatorDied, SimulatorError

        if not isinstance(error, AgentError | SimulatorDied | SimulatorError):
            raise
        return _fail(command, str(error))
    return status


def _fail(command: str, why: str) -> int:
    """Print why a command failed, with control characters escaped, and return the exit status."""
    from ovman.faults import printable

    print("\n".join(map(printable, f"ovman {command}: {why}".split("\n"))), file=sys.stderr)
    return 1


def _refuse_unknown_options(parser: argparse.ArgumentParser, given: Sequence[str]) -> None:
    """End with the usage of `parser` and the nearest option. argparse itself would first report missing arguments."""
    known = ["--help", *re.findall(r"--[\w-]+", parser.format_usage())]
    for word in takewhile(lambda word: word != "--", given):
        name = word.partition("=")[0]
        if name.startswith("--") and " " not in word and name not in known:
            parser.error(f"no such option: {name}{_nearest(name, known)}")


def _nearest(word: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(word, list(known), n=1)
    return f"; did you mean {near[0]}?" if near else ""
