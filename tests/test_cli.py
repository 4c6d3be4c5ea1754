"""The command line: help, and what is said to a command or an option that does not exist."""

from __future__ import annotations

import pytest

from ovman.cli import main


def test_alone_it_prints_the_help(capsys):
    assert main([]) == 0
    shown = capsys.readouterr().out
    assert all(f"\n    {name}" in shown for name in ("eval", "show", "doctor"))


@pytest.mark.parametrize(
    ("words", "usage", "said"),
    [
        (["evall"], "usage: ovman [", "evall; did you mean eval?"),
        (["xyzzy"], "usage: ovman [", "xyzzy; ovman --help"),
        (["eval", "--sceds", "0"], "usage: ovman eval ", "--sceds; did you mean --seeds?"),
        (["eval", "--split", "dev", "--out", "x", "--scene", "FloorPlan6"], "usage: ovman eval ", "did you mean --scenes?"),
        (["eval", "--spl=dev", "--out", "x"], "usage: ovman eval ", "--spl; did you mean --split?"),
        (["leaderboard", "one", "two"], "usage: ovman leaderboard ", "two"),
        (["serve", "--arm", "x", "--por", "1"], "usage: ovman serve ", "--por"),
        (["--verson"], "usage: ovman [", "--verson; did you mean --version?"),
    ],
)
def test_a_word_that_does_not_exist_is_refused_by_the_command_that_it_was_meant_for(capsys, words, usage, said):
    with pytest.raises(SystemExit) as ended:
        main(words)
    shown = capsys.readouterr()
    assert ended.value.code == 2 and shown.out == ""
    assert shown.err.startswith(usage) and said in shown.err.splitlines()[-1]
