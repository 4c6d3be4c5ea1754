"""The command line: help, and what is said to a command or an option that does not exist."""

from __future__ import annotations

import errno
import json
import os
import pty
import re
import subprocess
import sys
from contextlib import suppress

import pytest

from ovman.cli import main
from ovman.cli.commands import app

COLOUR = re.compile(r"\x1b\[[0-9;]*3[0-7]")


def test_alone_it_prints_the_help(capsys):
    assert main([]) == 0
    shown = capsys.readouterr().out
    assert all(f" {name} " in shown for name in ("eval", "show", "doctor"))


@pytest.mark.parametrize(
    ("words", "where", "said"),
    [
        (["evall"], "", 'Did you mean "eval"?'),
        (["xyzzy"], "", "See ovman --help"),
        (["eval", "--sceds", "0"], "ovman eval: ", "--sceds. Did you mean --seeds?"),
        (["eval", "--split", "dev", "--out", "x", "--scene", "FloorPlan6"], "ovman eval: ", "Did you mean --scenes?"),
        (["eval", "--spl=dev", "--out", "x"], "ovman eval: ", "--spl. Did you mean --split?"),
        (["eval", "--split", "dev", "--episodes", "x", "--out", "x"], "ovman eval: ", "--episodes"),
        (["eval", "--out", "x"], "ovman eval: ", "--split"),
        (["eval", "--split", "dev"], "ovman eval: ", "--out"),
        (["eval", "--split", "dev", "--out", "x", "--isolation", "docker"], "ovman eval: ", '"bubblewrap"'),
        (["draw", "--seed", "1", "--beacon", "x", "--out", "x"], "ovman draw: ", "--beacon"),
        (["draw", "--split", "everyday", "--homes", "1", "--out", "x"], "ovman draw: ", "--reveal"),
        (["draw", "--seed", "1", "--out", "x"], "ovman draw: ", "--homes N"),
        (["commit", "--homes", "1"], "ovman commit: ", "give --split, --closes, --out of a draw"),
        (["commit", "entry", "--seed", "1"], "ovman commit: ", "--seed is of a draw"),
        (["score", "points.jsonl", "--release", "nowhere"], "ovman score: ", "nowhere"),
        (["score", "points.jsonl", "--split"], "ovman score: ", "--split"),
        (["homes", "--out", "x", "--assets", "all"], "ovman homes: ", '"train"'),
        (["homes", "--out", "x", "--count", "two"], "ovman homes: ", "--count"),
        (["leaderboard", "one", "two"], "ovman leaderboard: ", "two"),
        (["serve", "--arm", "x", "--por", "1"], "ovman serve: ", "--port"),
        (["--verson"], "", "--verson. Did you mean --version?"),
    ],
)
def test_a_wrong_command_is_one_line(capsys, words, where, said):
    assert main(words) == 2
    shown = capsys.readouterr()
    assert shown.out == "" and shown.err.count("\n") == 1
    assert shown.err.startswith(where) and said in shown.err


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OSError(errno.ENOSPC, "No space left on device"), "No space left on device; free some space"),
        (PermissionError(errno.EACCES, "Permission denied", "cache/x"), "cache/x: Permission denied; name a folder"),
        (FileNotFoundError(errno.ENOENT, "No such file or directory", "x"), "x: No such file or directory"),
        (FileNotFoundError("x: make it first"), "x: make it first"),
    ],
)
def test_an_error_of_the_system_is_one_line(capsys, monkeypatch, error, said):
    def fail(*_):
        raise error

    monkeypatch.setattr("ovman.entry.listing.list_splits", fail)
    assert main(["splits"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"ovman splits: {said}") and "Errno" not in line


@pytest.mark.parametrize("command", [["splits"], ["agents"], ["episodes", "--split", "dev", "--scenes", "FloorPlan6"]])
def test_a_list_has_the_same_rows_as_json(capsys, command):
    assert main(command) == 0
    header, *lines = capsys.readouterr().out.splitlines()
    assert main([*command, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert len(rows) == len(lines) > 0
    for row, line in zip(rows, lines, strict=True):
        assert all(str(value) in line for value in row.values())
    assert all(name in header for name in rows[0])


def test_every_listed_agent_and_split_is_taken_by_the_evaluation(capsys, tmp_path):
    main(["agents", "--json"])
    agents = [row["agent"] for row in json.loads(capsys.readouterr().out)]
    for agent in agents:
        assert main(["eval", "--arm", agent, "--split", "main", "--scenes", "nowhere", "--out", str(tmp_path)]) == 1
        assert "--scenes: nowhere" in capsys.readouterr().err


def on_terminal(words: list[str], **environment: str) -> str:
    """Return what a command writes if its output is a terminal."""
    ours, theirs = pty.openpty()
    run = [sys.executable, "-m", "ovman.cli", *words]
    kept = {key: value for key, value in os.environ.items() if key not in ("NO_COLOR", "FORCE_COLOR")}
    process = subprocess.Popen(run, stdout=theirs, stderr=theirs, env=kept | {"TERM": "xterm", **environment})
    os.close(theirs)
    shown = b""
    with suppress(OSError):  # a terminal without a writer
        while part := os.read(ours, 4096):
            shown += part
    os.close(ours)
    process.wait(60)
    return shown.decode()


@pytest.mark.parametrize("words", [["splits"], ["evall"], ["homes", "--help"]])
def test_colour_is_for_terminals_that_want_it(words):
    assert COLOUR.search(on_terminal(words))
    assert not COLOUR.search(on_terminal(words, NO_COLOR="1"))
    run = [sys.executable, "-m", "ovman.cli", *words]
    piped = subprocess.run(run, capture_output=True, env=os.environ | {"TERM": "xterm"})
    assert b"\x1b" not in piped.stdout + piped.stderr


def test_progress_is_quiet_or_apart_from_json(capsys, tmp_path):
    command = ["homes", "--without-pictures", "--out", str(tmp_path / "homes")]
    assert main(command) == 0
    assert capsys.readouterr().out.startswith("1/1 Home-")
    assert main([*command, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert main([*command, "--json"]) == 0
    shown = capsys.readouterr()
    assert shown.err.startswith("1/1 Home-") and json.loads(shown.out)[0]["movable"] > 0


def test_completion_knows_the_commands_and_options(tmp_path):
    for shell, word in (("bash", "--scenes"), ("zsh", "--scenes"), ("fish", "-l scenes")):
        script = app.generate_completion(shell=shell)
        assert "leaderboard" in script and word in script
