from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.report.paper_comparison.metrics import Metrics, Missing, Reading, Take
from ovman.report.paper_comparison.paper import Figure, Paper
from ovman.report.paper_comparison.statement import Form
from ovman.report.paper_comparison.writing import p_value, papers, written
from tests.report.paper_comparison.papers import metrics_of

SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
RATES = metrics_of({"rates": [{"arm": "a", "relation": "all", "rate": "0.5"}, {"arm": "b", "relation": "all", "rate": ""}]})


def read_back(text: str) -> float:
    mantissa, _, exponent = text.translate(SUPERSCRIPTS).rpartition("10-")
    return float(text) if not exponent or "⁻" not in text else float(mantissa.strip(" ×") or 1) * 10 ** -int(exponent)


@given(st.floats(1e-290, 1.0))
def test_a_p_value_can_be_read_back(p):
    text = p_value(p)
    assert read_back(text) == pytest.approx(p, rel=0.06) if p < 0.001 else float(text) == pytest.approx(p, abs=0.000501)


@given(st.floats(-1, 1), st.sampled_from([Form.RATE, Form.DIFFERENCE]))
def test_a_rate_can_be_read_back_and_zero_has_no_sign(value, form):
    text = written(abs(value) if form is Form.RATE else value, form)
    assert float(text.replace("−", "-")) == pytest.approx(abs(value) if form is Form.RATE else value, abs=0.000501)
    assert (text in ("0.000",)) == (float(text.replace("−", "-")) == 0)


def test_figures_of_the_paper_are_written_like_ours():
    assert papers(Figure(value=0.416, place="a"), Form.RATE) == "0.416"
    assert papers(Figure(below=1e-22, place="a"), Form.P) == "< 10⁻²²"
    assert papers(Figure(low=0.228, high=0.346, place="a"), Form.RATE) == "0.228 – 0.346"
    assert [written(value, Form.METRES) for value in (25.5, 0.041)] == ["25.5 m", "0.04 m"]
    assert p_value(0.0) == "< 10⁻³⁰⁰"


def test_a_cell_knows_where_it_is_from():
    cell = RATES.read(Reading(file="rates", where={"arm": "a"}))
    assert (cell.value, cell.source) == (0.5, "rates.csv (a, all): rate")


@pytest.mark.parametrize(
    ("file", "where", "said"),
    [
        ("none", {"arm": "a"}, "there is no none.csv"),
        ("rates", {"arm": "c"}, "rates.csv has no row of c, all"),
        ("rates", {"arm": "b"}, "rates.csv (b, all): rate is empty"),
        ("rates", {"arm": "static.nowhere"}, "section paper of config.yaml names no arm for static.nowhere"),
    ],
)
def test_what_is_missing_is_one_line(file, where, said):
    with pytest.raises(Missing, match=re.escape(said)):
        RATES.read(Reading(file=file, where=where))
    assert RATES.find(Reading(file=file, where=where)) is None


@pytest.mark.parametrize("text", ["nan", "inf", "-inf", "many"])
def test_what_is_no_finite_number_is_refused(text):
    with pytest.raises(ValueError, match=f"rates.csv .a.: rate is '{text}'"):
        metrics_of({"rates": [{"arm": "a", "rate": text}]}).read(Reading(file="rates", where={"arm": "a"}))


def test_an_absent_column_and_a_row_that_occurs_twice_are_refused():
    with pytest.raises(ValueError, match="rates.csv: no column successes, there are arm, relation, rate"):
        RATES.read(Reading(file="rates", where={"arm": "a"}, column="successes"))
    with pytest.raises(ValueError, match="rates.csv: 2 rows of all, there must be one"):
        RATES.read(Reading(file="rates"))


def test_a_file_without_a_header_is_refused(tmp_path):
    (tmp_path / "rates.csv").write_text("")
    with pytest.raises(ValueError, match=r"rates.csv: no header; make it again"):
        Metrics.load([tmp_path / "rates.csv"], {})


SEEDS = metrics_of(
    {
        "seeds": [
            {"arm": "a", "seed": seed, "won": won, "n": "4", "scene": scene}
            for seed, won, scene in (("10", "1", "s"), ("2", "3", "s"), ("0", "2", "t"), ("0", "4", "u"))
        ]
    }
)


@pytest.mark.parametrize(
    ("how", "value", "source"),
    [
        ({"take": "mean"}, 2.5, "a, mean of 4): won"),
        ({"take": "min"}, 1.0, "a, lowest of 4, seed 10): won"),
        ({"take": "max", "column": "won / n"}, 1.0, "a, highest of 4, seed 0): won / n"),
        ({"nth_seed": 1}, 3.0, "a, seed 2): won"),
        ({"nth_seed": 2}, 1.0, "a, seed 10): won"),
        ({"take": "min", "query": "won > 2"}, 3.0, "a, 2 of 4 rows with won > 2, lowest of 2, seed 2): won"),
        ({"take": "min", "query": "won > 9", "default": 7.0}, 7.0, "a, 0 of 4 rows with won > 9): won"),
        ({"take": "distinct", "column": "scene, n"}, 3.0, "a, distinct): scene, n"),
        ({"take": "fewest"}, 2.0, "a, s, mean over runs): won"),
        ({"take": "second"}, 2.0, "a, t, mean over runs): won"),
        ({"take": "most"}, 4.0, "a, u, mean over runs): won"),
    ],
)
def test_what_is_made_of_several_rows(how, value, source):
    cell = SEEDS.read(Reading(file="seeds", where={"arm": "a"}, **{"column": "won", **how}))
    assert (cell.value, cell.source) == (value, f"seeds.csv ({source}")


def test_a_difference_names_both_of_its_numbers():
    one = Reading(file="seeds", where={"arm": "a"}, column="won", take=Take.MIN)
    cell = SEEDS.read(Reading(file="seeds", where={"arm": "a"}, column="won", take=Take.MAX, minus=one))
    assert cell.value == 3.0 and cell.source.count("seeds.csv (a, ") == 2 and " − " in cell.source


def test_too_few_rows_or_seeds_or_scenes_are_missing():
    few = metrics_of({"seeds": [{"arm": "a", "seed": "0", "won": "1", "scene": "s"}]})
    for how, said in (
        ({"take": "min", "least_rows": 2}, "seeds.csv has one row of a, which cannot differ from others"),
        ({"nth_seed": 1}, "seeds.csv has 1 of the 2 seeds of a that are needed"),
        ({"take": "most"}, "seeds.csv has 1 scenes, which is too few to tell one from the others"),
    ):
        with pytest.raises(Missing, match=re.escape(said)):
            few.read(Reading(file="seeds", where={"arm": "a"}, column="won", **how))


FIGURES = {
    "value: 0.5, below: 0.1": "a figure is a value",
    "low: 0.5": "a figure is a value",
    "low: 0.5, high: 0.1": "from low to high",
    "below: 2": "less than or equal to 1",
    "value: .nan": "finite",
}


@pytest.mark.parametrize("figure", FIGURES)
def test_a_figure_of_the_paper_is_one_of_three(tmp_path, figure):
    path = tmp_path / "paper.yaml"
    path.write_text(f"tables: {{}}\ntext:\n  speed: {{{figure}, place: here}}\nlater: {{}}\n")
    with pytest.raises(ValueError, match=FIGURES[figure]) as caught:
        Paper.read(path)
    assert "\n" not in str(caught.value) and str(path) in str(caught.value) and "text.speed" in str(caught.value)


def test_the_papers_tables_agree_with_themselves():
    paper = Paper.read()
    value = {key: figure.value for key, figure in paper.items()}
    relations = ("moved", "former", "moving", "stable", "appeared", "removed")
    n = {relation: value[f"taxonomy.episodes.{relation}"] for relation in relations}
    for key in paper:
        table, _, column = key.rpartition(".")
        if column != "all" or table == "embodied.cow":
            continue
        cells = [value[f"{table}.{relation}"] for relation in relations]
        if table.startswith("taxonomy."):
            assert sum(cells) == value[key], table
        else:
            mean = math.fsum(cell * n[relation] for cell, relation in zip(cells, relations, strict=True)) / sum(n.values())
            assert mean == pytest.approx(value[key], abs=0.0015), table
    for relation in (*relations, "all"):
        kinds = ("success", "abstain", "elsewhere", "near_miss", "wrong_instance")
        assert sum(value[f"taxonomy.{kind}.{relation}"] for kind in kinds) == value[f"taxonomy.episodes.{relation}"]
