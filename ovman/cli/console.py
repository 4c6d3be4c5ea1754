"""Print results, progress and errors of commands. Colour appears only on a terminal, and never if NO_COLOR is set."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from typing import TYPE_CHECKING, Any

from ovman.faults import printable
from ovman.processes import Step

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

Say = Callable[[str], None]
STYLES = {"success": "green", "failure": "red"}
"""Colours of cells."""
UNBOUNDED = 10_000
"""Columns of a file or pipe, where no row is wrapped."""


def print_text(text: str) -> None:
    """Print text that ends with a line feed, with its numbers and words in colour on a terminal."""
    if sys.stdout.isatty():
        from rich.console import Console  # takes longer to import than most commands run

        Console(soft_wrap=True, markup=False, emoji=False).print(text, end="")
    else:
        print(text, end="", flush=True)


def print_json(value: Any) -> None:
    """Print a value as JSON with a line feed."""
    print(json.dumps(value, indent=1, default=str), flush=True)


def print_rows(rows: Sequence[Mapping[str, Any]], as_json: bool) -> None:
    """Print rows that have the same keys as a table, or as JSON."""
    if as_json:
        print_json(rows)
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold cyan", highlight=True)
    for name, value in rows[0].items() if rows else ():
        table.add_column(name, justify="right" if isinstance(value, int | float) else "left")
    for row in rows:
        cells = [f"{value:.2f}" if isinstance(value, float) else str(value) for value in row.values()]
        table.add_row(*(Text(cell, STYLES[cell]) if cell in STYLES else cell for cell in cells))
    Console(width=None if sys.stdout.isatty() else UNBOUNDED, markup=False, emoji=False).print(table)


def print_note(line: str) -> None:
    """Print a line on standard error, with control characters escaped."""
    print(printable(line), file=sys.stderr, flush=True)


def print_error(command: str, why: str) -> None:
    """Print why a command failed on standard error: red on a terminal, control characters escaped."""
    text = "\n".join(map(printable, f"ovman {command}: {why}".removeprefix("ovman : ").split("\n")))
    if sys.stderr.isatty():
        from rich.console import Console

        Console(stderr=True, soft_wrap=True, markup=False, emoji=False, highlight=False).print(text, style="red")
    else:
        print(text, file=sys.stderr, flush=True)


@contextmanager
def report_progress(quiet: bool, to_stderr: bool = False, has_stages: bool = False) -> Iterator[Say]:
    """Yield what prints lines of progress; a `Step` moves a bar with the remaining time if there is a terminal.

    has_stages: Whether stages of the workflow run, which print progress of their own. It goes where the lines go.
    """
    if has_stages and (quiet or to_stderr):
        with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere if quiet else sys.stderr):
            yield ignore if quiet else print_line
        return
    stream = sys.stderr if to_stderr else sys.stdout
    if quiet or not stream.isatty():
        yield ignore if quiet else print_note if to_stderr else print_line
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (BarColumn(20), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}", markup=False))
    with Progress(*columns, console=Console(stderr=to_stderr, emoji=False)) as shown:
        yield Bar(shown, shown.add_task("", total=None, visible=False))


class Bar:
    """A bar of progress on a terminal. In another process it prints lines instead."""

    def __init__(self, shown: Progress, task: TaskID) -> None:
        self._shown, self._task = shown, task

    def __call__(self, line: str) -> None:
        """Move the bar to a step, or print another line above it."""
        if isinstance(line, Step):
            self._shown.update(self._task, visible=True, completed=line.done, total=line.total, description=printable(line.said))
        else:
            self._shown.console.print(printable(line), markup=False, highlight=False, soft_wrap=True)

    def __reduce__(self) -> tuple[Callable[..., Say], tuple[Say]]:
        """Return `print_line` for a worker process."""
        return _same, (print_line,)


def print_line(line: str) -> None:
    """Print a line on standard output, with control characters escaped."""
    print(printable(line), flush=True)


def ignore(line: str) -> None:
    """Print nothing."""


def _same(say: Say) -> Say:
    return say
