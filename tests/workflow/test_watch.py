"""The main job on a terminal: one line of progress, all of the log in a file, and what failed."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from functools import partial

import pytest

from ovman.progress import KEPT_S, Units, clock
from ovman.workflow.watch import EVERY, EXCERPT, excerpt, main, watch

JOBS = "".join(f"rule walks:\\n    noise\\n{k} of 200 steps ({k // 2}%) done\\n" for k in range(1, 201))


def says(text, status=0):
    """A command that says this and ends so."""
    return [sys.executable, "-c", f"import sys; print({text!r}, end=''); sys.exit({status})"]


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_terminal_has_one_line(tmp_path):
    out = Terminal()
    text = JOBS.replace("\\n", "\n")
    assert watch([says(text)], tmp_path / "logs" / "all.log", out) == 0
    assert out.getvalue().count("\n") == 2 and "\r" in out.getvalue()
    assert "jobs: 200 of 200 jobs, 0:00:0" in out.getvalue() and "walks" in out.getvalue()
    assert (tmp_path / "logs" / "all.log").read_text() == text
    assert str(tmp_path / "logs" / "all.log") in out.getvalue()


def test_a_file_has_some_lines(tmp_path):
    out = io.StringIO()
    watch([says(JOBS.replace("\\n", "\n"))], tmp_path / "all.log", out)
    assert EVERY <= out.getvalue().count("\n") <= EVERY + 2 and "\r" not in out.getvalue()


def test_what_fails_is_shown_and_ends_it(tmp_path, capsys):
    failing = "Building DAG\nnoise\nError in rule walks:\n    message: it fell\n"
    log = tmp_path / "all.log"
    assert watch([says(failing, 3), says("never\n")], log, io.StringIO()) == 3
    said = capsys.readouterr().err
    assert said.startswith("Error in rule walks:") and "it fell" in said and "noise" not in said and str(log) in said
    assert "never" not in log.read_text()


def test_an_error_of_one_line_is_shown():
    line = "config.yaml: association.gama_m is not a setting; did you mean gate_m?"
    assert excerpt(["", line]) == [line]
    long = [f"Error {k}" for k in range(500)]
    assert len(excerpt(long)) == EXCERPT + 1 and excerpt(long)[0] == "Error 0" and excerpt(long)[-1] == "Error 499"


@pytest.mark.parametrize("loud", [False, True])
def test_tables_are_shown_at_the_end(tmp_path, capfd, monkeypatch, loud):
    monkeypatch.setenv("V", "1" if loud else "")
    (tmp_path / "table.md").write_text("| a |\n")
    log = str(tmp_path / "all.log")
    assert main([log, ":::", *says("first\n"), ":::", *says("second\n"), "::::", str(tmp_path / "table.md")]) == 0
    said = capfd.readouterr().out
    assert said.endswith(f"{tmp_path / 'table.md'}\n\n| a |\n")
    assert ("first" in said) == loud and (tmp_path / "all.log").exists() != loud


def test_an_interrupt_reaches_the_command(tmp_path):
    """As from the keyboard: the whole group gets it, and what the command says of it is kept."""
    slow = "import time\ntry: print('begun', flush=True); time.sleep(60)\nexcept KeyboardInterrupt: print('ended well')\n"
    command = [sys.executable, "-m", "ovman.workflow.watch", str(tmp_path / "all.log"), ":::", sys.executable, "-c", slow]
    # Whoever runs the tests in the background may have it ignored.
    heeding = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen(command, start_new_session=True, stdout=subprocess.PIPE, preexec_fn=heeding) as process:
        while not (tmp_path / "all.log").exists() or "begun" not in (tmp_path / "all.log").read_text():
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        process.communicate(timeout=20)
    assert "ended well" in (tmp_path / "all.log").read_text()


def test_the_time_left_is_that_of_units_that_were_made(capsys):
    moments = iter([0.0, KEPT_S / 2, 10.0, 20.0])
    units = Units(5, lambda: next(moments))
    for name in "abc":
        units.done(name)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "1/5 a; 0:00:00 left"
    assert lines[1] == "2/5 b; 0:00:30 left" and lines[2] == "3/5 c; 0:00:20 left"
    assert clock(3661.2) == "1:01:01"
