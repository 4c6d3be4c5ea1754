"""A journal loses nothing that it confirmed and nothing that it did not confirm comes back."""

from __future__ import annotations

import json

from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.workflow.journal import Journal, digest


def test_a_unit_is_measured_once(tmp_path):
    calls = []
    for _ in range(3):
        journal = Journal(tmp_path / "j.jsonl")
        assert journal.unit("a", lambda: calls.append(1) or {"x": 1.5}) == {"x": 1.5}
    assert calls == [1]


@settings(derandomize=True, max_examples=60, deadline=None)
@given(st.integers(0, 400))
def test_cut_anywhere_it_keeps_every_whole_line_and_goes_on(tmp_path_factory, cut):
    path = tmp_path_factory.mktemp("journal") / "j.jsonl"
    journal = Journal(path)
    for k in range(6):
        journal.write(str(k), {"value": k, "text": "é" * k})
    data = path.read_bytes()
    path.write_bytes(data[: min(cut, len(data))])
    whole = data[: min(cut, len(data))].count(b"\n")
    again = Journal(path)
    assert [str(k) in again for k in range(6)] == [k < whole for k in range(6)]
    again.write("new", 7)
    assert Journal(path)["new"] == 7
    assert all(json.loads(line) for line in path.read_text().splitlines())


def test_a_digest_depends_on_content_and_not_on_key_order():
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1})
    assert digest({"a": 1, "b": 2}) != digest({"a": 2, "b": 1})
    assert digest("a", "b") != digest("ab")
