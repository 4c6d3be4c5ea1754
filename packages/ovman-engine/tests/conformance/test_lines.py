"""Every line of the contract has a test, every test names existing lines, and the page is up to date."""

from __future__ import annotations

import re

from conformance.lines import LINES, PAGE, marks, written


def test_every_line_has_a_test():
    assert {line for line, _, _ in marks()} == set(LINES)


def test_every_test_stands_for_something(request):
    marked = {(file, test) for _, file, test in marks()}
    for item in request.session.items:
        if item.path.parent == request.path.parent and item.path != request.path:
            assert (item.path.name, item.originalname) in marked, item.nodeid


def test_the_page_has_the_table():
    page = PAGE.read_text()
    assert page == written(page), "python tests/conformance/lines.py updates it"


def test_the_page_names_every_action_that_there_is():
    from ovman_engine.actions import TABLE

    named = set(re.findall(r"`(\w+)`", PAGE.read_text()))
    assert set(TABLE) <= named, set(TABLE) - named
