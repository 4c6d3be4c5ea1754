"""Snakemake with one line of progress: `python -m ovman.workflow.watch LOG ::: COMMAND [::: COMMAND ...] [:::: TABLE ...]`.

All that the commands say goes to the file LOG. Where one fails, what it said of it is shown, and the next is not run. With V=1 in
the environment nothing is held back, and there is no file.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path
from types import FrameType
from typing import IO

from ovman.progress import clock

STEPS = re.compile(r"^(\d+) of (\d+) steps \((\d+)%\) done")
RULE = re.compile(r"^(?:local)?(?:rule|checkpoint) (\w+):")
NEXT, SHOWN = ":::", "::::"
EXCERPT = 40
"""Lines at most that are shown of a command that failed."""
BEGINS = ("Error", "Exception", "Traceback", "WorkflowError", "SyntaxError", "LockException", "MissingInputException")
"""What the first line of a failure begins with, after its colour; what comes before is no part of it."""
EVERY = 20
"""Lines of progress at most where the output is no terminal."""


class Line:
    """The one line: rewritten on a terminal; elsewhere a new one at each further part of `EVERY`."""

    def __init__(self, out: IO[str], name: str) -> None:
        self._out, self._name, self._begun = out, name, time.monotonic()
        self._shown, self._width, self._rule, self._counts = -1, 0, "", (0, 0)

    def hear(self, said: str) -> None:
        """Take a line of Snakemake's."""
        if found := STEPS.match(said):
            self._counts = int(found[1]), int(found[2])
            self._show()
        elif found := RULE.match(said):
            self._rule = found[1]
            if self._out.isatty():
                self._show()

    def _show(self) -> None:
        done, total = self._counts
        text = f"{self._name}: {done} of {total} jobs, {clock(time.monotonic() - self._begun)}" if total else f"{self._name}:"
        if self._out.isatty():
            text = f"{text} {self._rule}"
            print(f"\r{text:<{self._width}}", end="", file=self._out, flush=True)
            self._width = len(text)
        elif total and (done == total or done * EVERY // total > self._shown):
            self._shown = done * EVERY // total
            print(text, file=self._out, flush=True)

    def end(self) -> None:
        """Leave the line as it is."""
        if self._width:
            print(file=self._out, flush=True)


def watch(commands: Sequence[Sequence[str]], log: Path, out: IO[str]) -> int:
    """Run the commands one after the other, with their output in `log`; the exit status of the first that fails, else 0."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("w", encoding="utf-8") as file:
        for number, command in enumerate(commands, start=1):
            name = f"{number}/{len(commands)}" if len(commands) > 1 else "jobs"
            line, said = Line(out, name), list[str]()
            with subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
            ) as process:
                assert process.stdout is not None, "it is a pipe"
                with _patient(process):
                    for text in process.stdout:
                        file.write(text)
                        file.flush()
                        said.append(text.rstrip("\n"))
                        line.hear(said[-1])
            line.end()
            if process.returncode:
                print("\n".join(excerpt(said)), file=sys.stderr)
                print(f"The whole log: {log}", file=sys.stderr)
                return process.returncode if process.returncode > 0 else 128 - process.returncode
    print(f"The whole log: {log}", file=out)
    return 0


def excerpt(said: Sequence[str]) -> list[str]:
    """What a command that failed said of it: from the first line of a failure on, or its last lines where none is known."""
    start = next((k for k, line in enumerate(said) if line.startswith(BEGINS)), max(len(said) - EXCERPT, 0))
    shown = [line for line in said[start:] if line.strip()]
    return shown if len(shown) <= EXCERPT else [*shown[: EXCERPT // 2], "...", *shown[-EXCERPT // 2 :]]


@contextmanager
def _patient(process: subprocess.Popen[str]) -> Iterator[None]:
    """Ctrl-C reaches the process as well: it ends in its own way, and is killed at the second."""
    pressed = []

    def press(number: int, frame: FrameType | None) -> None:
        pressed.append(number)
        if len(pressed) > 1:
            process.kill()

    before = signal.signal(signal.SIGINT, press)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def main(arguments: Sequence[str]) -> int:
    """Returns the exit status. arguments: the log, the commands, each after ":::", and the tables that are shown after "::::"."""
    log, *rest = arguments
    end = rest.index(SHOWN) if SHOWN in rest else len(rest)
    shown = rest[end + 1 :]
    commands = [list(part) for is_break, part in groupby(rest[:end], key=lambda word: word == NEXT) if not is_break]
    if os.environ.get("V") == "1":
        status = next((code for command in commands if (code := subprocess.call(command))), 0)
    else:
        status = watch(commands, Path(log), sys.stdout)
    if status == 0:
        for name in shown:
            print(f"\n{name}\n\n{Path(name).read_text(encoding='utf-8').rstrip()}")
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
