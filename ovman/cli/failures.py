"""Failures of commands: one line, and no traceback."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable

EXTRAS = {"gymnasium": "gym", "pyarrow": "dataset"} | dict.fromkeys(
    ("torch", "torchvision", "ultralytics", "open_clip", "onnx", "safetensors"), "networks"
)
"""The extra that brings a module; without one the benchmark itself requires it."""


def guard(command: str, work: Callable[[Namespace], int], interrupted: str = "interrupted") -> Callable[[Namespace], int]:
    """Return a command's work, with one line on standard error instead of a traceback if it fails.

    The work imports what it needs, of which some may not be installed. interrupted: the line after Ctrl-C, which may name options
    of the command, such as {out}.
    """

    def run(options: Namespace) -> int:
        return said(command, lambda: work(options), interrupted.format(**vars(options)))

    return run


def said(command: str, work: Callable[[], int], interrupted: str = "interrupted") -> int:
    """Return the exit status of what `work` does for `command`, as `guard`."""
    try:
        return work()
    except ModuleNotFoundError as missing:
        if (missing.name or "").split(".")[0] == "ovman":
            raise
        extra = EXTRAS.get(missing.name or "")
        install = "pip install ." if extra is None else f"pip install '.[{extra}]'"
        print(f"ovman {command}: {missing.name} is not installed; in a checkout of OVMAN: {install}", file=sys.stderr)
        return 1
    except (ValueError, OSError) as error:
        return _failed(command, error)
    except KeyboardInterrupt:
        print(f"ovman {command}: {interrupted}", file=sys.stderr)
        return 130
    except Exception as error:
        if not isinstance(error, _known()):
            raise
        return _failed(command, error)


def _failed(command: str, error: Exception) -> int:
    """Print what failed, with control characters escaped, and return the exit status."""
    from ovman.faults import printable  # most commands fail at nothing

    lines = map(printable, f"ovman {command}: {error}".split("\n"))
    print("\n".join(lines), file=sys.stderr)
    return 1


def _known() -> tuple[type[Exception], ...]:
    """Return failures with a message of one line. Imported late: most commands start no simulator."""
    from ovman.evaluation.supervision import AgentError
    from ovman.sim.session import SimulatorDied, SimulatorError

    return AgentError, SimulatorDied, SimulatorError
