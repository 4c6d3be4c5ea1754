"""The command `ovman`."""

from __future__ import annotations

import argparse
import difflib
import re
import sys
from collections.abc import Iterable, Sequence
from itertools import takewhile
from typing import Any

from ovman import __version__, kernels
from ovman.cli import entries, results


class Parser(argparse.ArgumentParser):
    """A parser that takes no abbreviated options."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, **settings)


def main(arguments: Sequence[str] | None = None) -> int:
    """Return the exit status: 0 for success, 1 if something that was asked for failed, 2 for a wrong command."""
    kernels.hold()
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given[:1] == ["serve"]:  # its own parser says what is served: the module that has it loads the networks' side
        from ovman.entry.serve import main as serve

        return serve(given[1:])
    parser = Parser(prog="ovman", description="Open-vocabulary motion-aware navigation.")
    parser.add_argument("--version", action="version", version=f"ovman {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="command", parser_class=Parser)
    for room in (results, entries):
        room.add(commands)
    if not given:
        parser.print_help()
        return 0
    if not given[0].startswith("-") and given[0] not in commands.choices:
        parser.error(f"no such command: {given[0]}{_nearest(given[0], commands.choices) or '; ovman --help lists all'}")
    chosen = commands.choices.get(given[0], parser)
    _refuse_unknown_options(chosen, given)
    options, left = parser.parse_known_args(given)
    if left or options.command is None:
        chosen.error(f"unrecognized arguments: {' '.join(left)}")
    status: int = options.run(options)
    return status


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
