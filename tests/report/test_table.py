from __future__ import annotations

import csv
import io

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.report.latex import escaped, latex
from ovman.report.markdown import markdown
from ovman.report.table import DATA, PAGE, Column, Row, Table, Text, csv_text

TABLE = Table(
    name="sample",
    caption="Rates & ranges of 2 arms.",
    columns=(
        Column("arm", "arm"),
        Column("rate", Text("RATE", r"\textsc{rate}"), numeric=True),
        Column("rate_low", "low", numeric=True, formats=DATA),
        Column("range", "95 %", formats=PAGE),
    ),
    rows=(
        Row({"arm": "one_visit", "rate": "0.250", "rate_low": "0.1", "range": "0.1–0.4"}),
        Row({"arm": Text("γ, long name", r"$\gamma$, long name"), "rate_low": "0.2", "range": "0.2–1.0"}, section="handed over"),
    ),
)


def test_csv_holds_the_data():
    assert csv_text(TABLE) == 'arm,rate,rate_low\none_visit,0.250,0.1\n"γ, long name",,0.2\n'


def test_markdown_lines_up():
    assert markdown(TABLE) == (
        "Rates & ranges of 2 arms.\n"
        "\n"
        "| arm          |  RATE | 95 %    |\n"
        "| ------------ | ----: | ------- |\n"
        "| one_visit    | 0.250 | 0.1–0.4 |\n"
        "| γ, long name |     — | 0.2–1.0 |\n"
    )


def test_latex_is_booktabs_with_headings_of_sections():
    assert latex(TABLE) == (
        "\\begin{table}[t]\\centering\\small\n"
        "\\caption{Rates \\& ranges of 2 arms.}\\label{tab:sample}\n"
        "\\begin{tabular}{lrl}\n"
        "\\toprule\n"
        "arm & \\textsc{rate} & 95 \\% \\\\\n"
        "\\midrule\n"
        "one\\_visit & 0.250 & 0.1--0.4 \\\\\n"
        "\\midrule\n"
        "\\multicolumn{3}{l}{\\emph{handed over}} \\\\\n"
        "$\\gamma$, long name & --- & 0.2--1.0 \\\\\n"
        "\\bottomrule\n"
        "\\end{tabular}\n"
        "\\end{table}\n"
    )


cells = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=12)


@settings(max_examples=80, derandomize=True)
@given(st.lists(st.tuples(cells, cells), min_size=1, max_size=5))
def test_no_cell_breaks_out_of_its_table(rows):
    table = Table("t", "c", (Column("a", "a"), Column("b", "b")), tuple(Row({"a": a, "b": b}) for a, b in rows))
    assert list(csv.reader(io.StringIO(csv_text(table))))[1:] == [list(row) for row in rows]
    lines = markdown(table).splitlines()[2:]
    assert len({len(line) for line in lines}) == 1
    assert all(line.replace(r"\|", "").count("|") == 3 for line in lines)
    body = latex(table).splitlines()[6 : 6 + len(rows)]
    assert all(line.replace(r"\&", "").count("&") == 1 and line.endswith(r" \\") for line in body)
    assert not any(special in line.replace("\\" + special, "") for line in body for special in "#%_")


def test_what_latex_may_not_have_is_refused():
    assert escaped("50 % of {a_b}") == r"50 \% of \{a\_b\}"
    with pytest.raises(ValueError, match="no LaTeX for γ"):
        escaped("γ")


def test_a_cell_belongs_to_a_column():
    with pytest.raises(ValueError, match="no column for b"):
        Table("t", "c", (Column("a", "a"),), (Row({"b": "1"}),))
    with pytest.raises(ValueError, match="one key"):
        Table("t", "c", (Column("a", "a"), Column("a", "b")), ())
