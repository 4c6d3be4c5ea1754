"""Rows of metrics as csv files, read without data frames."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
import pytest

from ovman.analysis.rows import csv_text, read_rows, write_csv


@dataclass(frozen=True)
class Row:
    """A row with every kind of column; the last may be absent."""

    arm: str
    share: float
    count: int
    some: int | None
    known: bool | None
    said: str | None
    more: float | None = None


HEADER = "share,arm,count,some,known,said,further\n"


def read(tmp_path, text, arms=None):
    path = tmp_path / "rows.csv"
    path.write_text(text, encoding="utf-8")
    return read_rows(path, Row, arms)


def test_a_column_is_found_by_its_name_and_empty_text_is_none(tmp_path):
    text = HEADER + '0.5,a,3,,1,"b,c",x\n-1e-3,b,0,7,0,,\n'
    assert read(tmp_path, text) == [Row("a", 0.5, 3, None, True, "b,c"), Row("b", -0.001, 0, 7, False, None)]


def test_only_rows_of_the_arms_are_read(tmp_path):
    """The cells of another arm are not looked at."""
    text = HEADER + "0.5,a,3,,,,\nmany,b,,,,,\n1,c,1,,,,\n"
    assert [row.arm for row in read(tmp_path, text, {"a", "c"})] == ["a", "c"] and read(tmp_path, text, ()) == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("share,arm\n1,a\n", "count in row 1: Field required"),
        (HEADER + "many,a,3,,,,\n", "share in row 1: Input should be a valid number"),
        (HEADER + "1,a,1,,,,\n,a,3,,,,\n", "share in row 2: Input should be a valid number"),
        (HEADER + "1,a,2.5,,,,\n", "count in row 1: Input should be a valid integer"),
    ],
)
def test_unreadable_text_is_reported_in_one_line(tmp_path, text, said):
    with pytest.raises(ValueError) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path / 'rows.csv'}: {said}") and "\n" not in str(caught.value)


def test_rows_come_back_from_a_file_as_they_were(tmp_path):
    rows = [Row("a", 0.25, 3, None, True, "b,c"), Row("b", -0.5, 0, 7, None, None, 1.0)]
    write_csv(tmp_path / "rows.csv", "arm share count some known said more", rows)
    assert read_rows(tmp_path / "rows.csv", Row) == rows


@pytest.mark.parametrize(
    ("value", "text"),
    [(-4e-7, "0.000000"), (-0.0, "0.000000"), (-6e-7, "-0.000001"), (0.1234565, "0.123456"), (2.0 / 3.0, "0.666667")],
)
def test_a_number_has_six_decimals_rounded_exactly_and_no_lone_sign(value, text):
    assert csv_text("share", [{"share": value}, {"share": np.float64(value)}]) == f"share\n{text}\n{text}\n"


def test_p_values_keep_six_digits_and_lines_end_with_a_line_feed(monkeypatch):
    monkeypatch.setattr(os, "linesep", "\r\n")
    rows = [
        {"p": 1.5e-23, "n": np.int64(3), "said": "b,c", "known": True, "more": 1},
        {"p": None, "n": 0, "said": None, "known": np.bool_(False)},
    ]
    assert csv_text("p n said known", rows) == 'p,n,said,known\n1.5e-23,3,"b,c",1\n,0,,0\n'
