"""A survivor without an explanation is found, and so is an explanation without a survivor."""

from __future__ import annotations

import pytest

from tests.mutation.survivors import Comparison, Mutant, changed_line, compare, read_elsewhere, read_explained

KNOWN, NEW, KILLED = (Mutant("ovman.task.answer.answer", "return a", f"return {x}") for x in "bcd")


def test_survivors_and_explanations_are_compared_both_ways():
    assert compare([KNOWN, NEW], {KNOWN: "equal", KILLED: "equal"}) == Comparison((NEW,), (KILLED,))
    assert compare([KNOWN], [KNOWN]) == Comparison((), ())


def test_a_mutant_is_known_by_its_lines_whatever_their_place():
    diff = "--- a.py\n+++ a.py\n@@ -1,3 +1,3 @@\n def f(x):\n-    if x < 1:\n+    if x <= 1:\n         return -x\n"
    assert changed_line("a.f", diff) == Mutant("a.f", "if x < 1:", "if x <= 1:")
    removed = "--- a.py\n+++ a.py\n@@ -1,3 +1,1 @@\n def f(x):\n-    case 1:\n-        return 2\n"
    assert changed_line("a.f", removed) == Mutant("a.f", "case 1:\nreturn 2", "")


def test_each_explained_survivor_has_one_reason(tmp_path):
    assert all(reason.strip() for reason in read_explained().values())
    entry = '[[survivor]]\nfunction = "f"\nline = "a"\nmutants = ["b"]\nreason = "{}"\n'
    file = tmp_path / "survivors.toml"
    file.write_text(entry.format("equal") * 2)
    with pytest.raises(ValueError, match="explains a mutant twice"):
        read_explained(file)
    file.write_text(entry.format(" "))
    with pytest.raises(ValueError, match="f has no reason"):
        read_explained(file)


def test_functions_that_other_tests_run_name_tests_that_are_there(tmp_path):
    assert all(name.startswith("ovman.") for name in read_elsewhere())
    file = tmp_path / "survivors.toml"
    file.write_text('[[elsewhere]]\nfunctions = ["ovman.task.answer.answer"]\ntests = "tests/nowhere"\n')
    with pytest.raises(ValueError, match="tests/nowhere is not there"):
        read_elsewhere(file)
