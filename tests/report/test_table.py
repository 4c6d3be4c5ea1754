from __future__ import annotations

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.report.tables.columns import words
from ovman.report.tables.table import Group, Table, csv_text, escape_latex, latex, markdown
from tests.arms import CONFIG

cells = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=12)


@given(st.lists(st.tuples(cells, cells), min_size=1, max_size=5))
def test_no_cell_breaks_out_of_its_table(rows):
    table = Table("c", (words("a"), words("b")), tuple(Group([{"a": a, "b": b}], CONFIG) for a, b in rows), ("",) * len(rows))
    assert list(csv.reader(io.StringIO(csv_text(table))))[1:] == [list(row) for row in rows]
    lines = markdown(table).splitlines()[2:]
    assert len({len(line) for line in lines}) == 1
    assert all(line.replace(r"\|", "").count("|") == 3 for line in lines)
    body = latex(table, "t").split("\\midrule\n")[1].splitlines()[: len(rows)]
    assert all(line.replace(r"\&", "").count("&") == 1 and line.endswith(r" \\") for line in body)
    assert not any(special in line.replace("\\" + special, "") for line in body for special in "#%_")


def test_what_latex_may_not_have_is_refused():
    assert escape_latex("50 % of {a_b}") == r"50 \% of \{a\_b\}"
    with pytest.raises(ValueError, match="no LaTeX for γ"):
        escape_latex("γ")


def test_columns_have_different_keys():
    with pytest.raises(ValueError, match="two columns of a table are called a"):
        Table("c", (words("a"), words("a", "b")), ())


def test_a_group_gives_the_value_over_all_relations():
    rows = [{"relation": "moved", "n": 1}, {"relation": "all", "n": 3}]
    assert Group(rows, CONFIG).get("n") == 3 and Group(rows, CONFIG).where(relation="moved").get("n") == 1
    assert Group(rows[:1], CONFIG).get("n") == 1 and Group(rows, CONFIG).get("rate") is None
    assert Group(rows, CONFIG).where(relation="former").get("n") is None
