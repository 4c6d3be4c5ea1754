"""Numbers of the metrics with their sources, and how figures are written."""

from __future__ import annotations

import re

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.report.metrics import Metrics, Missing
from ovman.report.paper import COUNT, DIFFERENCE, METRES, RATE, P, Printed, write, write_p
from ovman.report.tables.table import type_metrics

SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def metrics_of(**files: list[dict[str, str]]) -> Metrics:
    return Metrics({name: type_metrics(pd.DataFrame(rows).fillna("")) for name, rows in files.items()}, {"static.two": "a"})


RATES = metrics_of(
    rates=[
        {"arm": "a", "relation": "all", "rate": "0.5"},
        {"arm": "b", "relation": "all", "rate": ""},
        {"arm": "a", "relation": "moved", "rate": "0.25"},
    ],
    seeds=[{"arm": "a", "seed": seed, "rate": rate} for seed, rate in (("10", "0.4"), ("2", "0.1"), ("3", "0.3"))],
    pairs=[{"arm": "a", "difference": difference, "p": p} for difference, p in (("0.1", "0.5"), ("0.2", "0.04"), ("-0.1", "0"))],
)


def test_a_number_knows_its_source():
    one, moved = RATES.rows("rates", arm="a").one(), RATES.rows("rates", arm="static.two", relation="moved").one()
    assert (one, one.source) == (0.5, "rates.csv (a, all): rate")
    difference = one - moved
    assert (difference, difference.source) == (0.25, "rates.csv (a, all): rate − rates.csv (a, moved): rate")
    seeds = RATES.rows("seeds", arm="a")
    assert (seeds.lowest().source, seeds.lowest()) == ("seeds.csv (a, lowest of 3, seed 2): rate", 0.1)
    assert seeds.highest() == 0.4 and seeds.mean() == pytest.approx(0.8 / 3)
    assert seeds.of_seed(0).one().source == "seeds.csv (a, seed 2): rate", "seeds are numbers"
    assert RATES.rows("rates", relation=("all", "moved")).count_distinct("arm") == 2


def test_the_lowest_p_is_that_of_pairs_with_a_lead():
    rows = RATES.rows("pairs", arm="a")
    assert rows.lowest_positive("p", of="difference", otherwise=1.0) == 0.04
    behind = metrics_of(pairs=[{"difference": "-0.1", "p": "0"}]).rows("pairs")
    assert behind.lowest_positive("p", of="difference", otherwise=1.0) == 1.0


@pytest.mark.parametrize(
    ("read", "missing"),
    [
        (lambda: RATES.rows("none", arm="a"), "there is no none.csv"),
        (lambda: RATES.rows("rates", arm="c"), "rates.csv has no row of c, all"),
        (lambda: RATES.rows("rates", arm="b").one(), "rates.csv (b, all): rate is empty"),
        (lambda: RATES.rows("rates", arm="static.nowhere"), "name no arm for static.nowhere"),
        (lambda: RATES.rows("rates", arm="controls.nobody"), "name no arm for controls.nobody"),
        (lambda: RATES.rows("seeds", arm="a").of_seed(3), "seeds.csv has 3 of the 4 seeds of a that are needed"),
    ],
)
def test_a_missing_number_says_why(read, missing):
    with pytest.raises(Missing, match=re.escape(missing)):
        read()


def test_a_row_that_occurs_twice_is_refused():
    with pytest.raises(ValueError, match="rates.csv: 2 rows of all, there must be one; make the metrics again"):
        RATES.rows("rates").one()


def test_a_file_without_rows_is_missing(tmp_path):
    (tmp_path / "rates.csv").write_text("arm,rate\n")
    metrics = Metrics.load([tmp_path / "rates.csv"], {})
    with pytest.raises(Missing, match=r"rates\.csv has no rows"):
        metrics.frame("rates")
    assert metrics.write("rates", arm="a") == "—" and RATES.write("rates", arm="a") == "0.500"


def test_other_arms_take_the_place_of_those_that_they_replace():
    metrics = Metrics({"rates": pd.DataFrame({"arm": ["x", "y"], "rate": [1, 2]})}, {"static.a": "x", "static.b": "y"})
    assert metrics.with_arms({"static.a": "static.b"}).rows("rates", arm="static.a").one() == 2
    with pytest.raises(Missing, match=r"name no arm for static\.c"):
        metrics.with_arms({"static.a": "static.c"}).rows("rates", arm="static.a")


def read_back(text: str) -> float:
    mantissa, _, exponent = text.translate(SUPERSCRIPTS).rpartition("10-")
    return float(text) if not exponent or "⁻" not in text else float(mantissa.strip(" ×") or 1) * 10 ** -int(exponent)


@given(st.floats(1e-290, 1.0))
def test_a_p_value_can_be_read_back(p):
    text = write_p(p)
    assert read_back(text) == pytest.approx(p, rel=0.06) if p < 0.001 else float(text) == pytest.approx(p, abs=0.000501)


@given(st.floats(-1, 1), st.sampled_from([RATE, DIFFERENCE]))
def test_a_rate_can_be_read_back_and_zero_has_no_sign(value, form):
    value = abs(value) if form is RATE else value
    text = write(value, form)
    assert float(text.replace("−", "-")) == pytest.approx(value, abs=0.000501)
    assert (text == "0.000") == (float(text.replace("−", "-")) == 0)


def test_figures_of_the_paper_are_written_like_ours():
    assert Printed("a", 0.416, 0.416).write() == "0.416"
    assert Printed("a", 0.0, 1e-22).write(P) == "< 10⁻²²"
    assert Printed("a", 0.228, 0.346).write() == "0.228 – 0.346" and Printed("a", 30, 34).write(COUNT) == "30 – 34"
    assert [write(value, METRES) for value in (25.5, 0.041)] == ["25.5 m", "0.04 m"]
    assert write_p(0.0) == "< 10⁻³⁰⁰"
