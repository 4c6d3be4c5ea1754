"""The command `ovman`."""

from __future__ import annotations

import difflib
import errno
import sys
from collections.abc import Callable, Sequence
from inspect import BoundArguments
from itertools import takewhile
from typing import Any

from cyclopts import CycloptsError

from ovman import kernels
from ovman.cli.commands import INTERRUPTED, app
from ovman.cli.console import print_error

EXTRAS = {"gymnasium": "gym", "py_ecc": "beacon", "pyarrow": "dataset"}
"""The extra that brings a module; without one the benchmark itself requires it."""
FULL, NOT_WRITABLE = "free some space, or name folders on another disk", "name a folder that you may read and write"
REMEDIES = {errno.ENOSPC: FULL, errno.EDQUOT: FULL, errno.EACCES: NOT_WRITABLE, errno.EROFS: NOT_WRITABLE}
"""Remedies by the number that the system gives an error."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Return the exit status: 0 for success, 1 if something that was asked for failed, 2 for a wrong command."""
    kernels.hold()
    given = list(sys.argv[1:] if arguments is None else arguments)
    name = given[0] if given and given[0] in app else ""
    try:
        command, bound, _ = app.parse_args(given, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        says = _unknown_option(name, given) or " ".join(str(error).split())
        print_error(name, f"{says} See {f'ovman {name}'.strip()} --help.")
        return 2
    return _run(name, command, bound)


def _unknown_option(name: str, given: Sequence[str]) -> str | None:
    """Return what is wrong with the first option that a command does not have. Cyclopts first reports missing ones."""
    known = [*app] if not name else [*app.help_flags, *(n for one in app[name].assemble_argument_collection() for n in one.names)]
    for word in takewhile(lambda word: word != "--", given):
        option = word.partition("=")[0]
        if option.startswith("--") and " " not in option and option not in known:
            near = difflib.get_close_matches(option, known, n=1)
            return f"Unknown option: {option}.{f' Did you mean {near[0]}?' if near else ''}"
    return None


def _run(name: str, command: Callable[..., Any], bound: BoundArguments) -> int:
    """Return the exit status of a command; print one line instead of a traceback if it fails."""
    try:
        return command(*bound.args, **bound.kwargs) or 0
    except ModuleNotFoundError as missing:
        if (missing.name or "").split(".")[0] == "ovman":
            raise
        extra = EXTRAS.get(missing.name or "")
        install = "pip install ." if extra is None else f"pip install '.[{extra}]'"
        print_error(name, f"{missing.name} is not installed; in a checkout of OVMAN: {install}")
        return 1
    except KeyboardInterrupt:
        print_error(name, INTERRUPTED.get(name, "interrupted").format(**bound.arguments))
        return 130
    except (ValueError, OSError) as error:
        print_error(name, _explain(error))
        return 1
    except Exception as error:
        from ovman.evaluation.supervision import AgentError  # slow, and most commands start no simulator
        from ovman.sim.session import SimulatorDied, SimulatorError

        if not isinstance(error, AgentError | SimulatorDied | SimulatorError):
            raise
        print_error(name, " ".join(str(error).split()))  # AI2-THOR's errors have several lines
        return 1


def _explain(error: ValueError | OSError) -> str:
    """Return what an error says; of one of the system the file, the problem and the remedy."""
    if not isinstance(error, OSError) or error.strerror is None:
        return str(error)
    place = "" if error.filename is None else f"{error.filename}: "
    remedy = REMEDIES.get(error.errno or 0)
    return f"{place}{error.strerror}" + (f"; {remedy}" if remedy else "")
