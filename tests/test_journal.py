"""A journal loses nothing that it confirmed and nothing that it did not confirm comes back."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.workflow.journal import Fault, Journal, contents, digest


def test_a_unit_is_measured_once(tmp_path):
    calls = []
    for _ in range(3):
        journal = Journal(tmp_path / "j.jsonl")
        assert journal.unit("a", lambda: calls.append(1) or {"x": 1.5}) == {"x": 1.5}
    assert calls == [1]


@given(st.integers(0, 500))
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


def three(path):
    journal = Journal(path)
    for k in range(3):
        journal.write(str(k), {"value": 100 + k, "text": "é", "at": [0.1, -2.5e-7, None]})
    return path.read_bytes().split(b"\n")[:-1]


DAMAGES = {
    "a changed digit": (lambda line: line.replace(b"101", b"107"), "its content does not match its digest"),
    "a changed key": (lambda line: line.replace(b'"key":"1"', b'"key":"8"'), "its content does not match its digest"),
    "another digest": (lambda line: line[:-3] + b'x"}', "its content does not match its digest"),
    "no UTF-8": (lambda line: line.replace(b"value", b"val\xffe"), "is not JSON in UTF-8"),
    "no JSON": (lambda line: line[:-1], "is not JSON in UTF-8"),
    "shortened": (lambda line: line[5:], "is not JSON in UTF-8"),
    "of something else": (lambda line: b'{"a":1}', "has no key or no record"),
    "a list": (lambda line: b"[1]", "has no key or no record"),
    "of an older version": (lambda line: line[: line.index(b',"digest"')] + b"}", "has no digest of its content"),
    "an empty line": (lambda line: b"", "is not JSON in UTF-8"),
}


@pytest.mark.parametrize(("damage", "problem"), DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_line_is_named_and_its_unit_alone_is_made_again(tmp_path, capfd, damage, problem):
    path = tmp_path / "j.jsonl"
    first, second, third = three(path)
    path.write_bytes(b"\n".join([first, damage(second), third, b""]))
    assert contents(path).faults == [Fault(2, problem)]
    assert capfd.readouterr().out == ""
    again = Journal(path)
    assert capfd.readouterr().out == f"{path}, line 2: {problem}; its unit is made again\n"
    assert [str(k) in again for k in range(3)] == [True, False, True] and "8" not in again
    made = again.unit("1", lambda: {"value": 101})
    assert made == {"value": 101} and Journal(path)["0"]["value"] == 100
    # The damaged line is gone, so that it is named once.
    assert capfd.readouterr().out == "" and path.read_bytes().startswith(first + b"\n" + third + b"\n")


def test_a_torn_end_is_named(tmp_path, capfd):
    path = tmp_path / "j.jsonl"
    three(path)
    path.write_bytes(path.read_bytes()[:-20])
    assert "2" not in Journal(path) and "1" in Journal(path)
    assert capfd.readouterr().out == f"{path}, line 3: is torn; its unit is made again\n"


@given(st.data())
def test_no_flipped_bit_passes_unnoticed(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("journal") / "j.jsonl"
    three(path)
    before = contents(path).units
    spoiled = bytearray(path.read_bytes())
    at = data.draw(st.integers(0, len(spoiled) - 1))
    spoiled[at] ^= 1 << data.draw(st.integers(0, 7))
    path.write_bytes(spoiled)
    after = contents(path)
    assert after.units.items() <= before.items()
    assert len(after.units) >= len(before) - 2
    assert after.faults or after.units == before


def test_a_digest_depends_on_content_and_not_on_key_order():
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1})
    assert digest({"a": 1, "b": 2}) != digest({"a": 2, "b": 1})
    assert digest("a", "b") != digest("ab")
