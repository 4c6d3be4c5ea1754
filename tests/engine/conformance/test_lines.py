"""Every line of the contract has a test, and every test names lines that there are."""

from __future__ import annotations

from tests.engine.conformance.lines import LINES, marks, table


def test_every_line_has_a_test():
    assert {line for line, _, _ in marks()} == set(LINES)


def test_every_test_stands_for_something(request):
    marked = {(file, test) for _, file, test in marks()}
    for item in request.session.items:
        if item.path.parent == request.path.parent and item.path != request.path:
            assert (item.path.name, item.originalname) in marked, item.nodeid


def test_the_table_has_a_row_for_each_line():
    assert table().count("\n") == len(LINES) + 2 and "| `" in table()
