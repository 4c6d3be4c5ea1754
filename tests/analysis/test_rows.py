"""Rows of metrics read without data frames."""

from __future__ import annotations

import os
from dataclasses import dataclass
from enum import StrEnum

import pandas as pd
import pytest

from ovman.analysis import frames
from ovman.analysis.frames import csv_text, dtypes, frame_of, rows_of, typed, write
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import Rate
from ovman.analysis.rows import read_rows
from ovman.analysis.significance import Comparison
from tests.episodes import DATA


@dataclass(frozen=True)
class Row:
    """A row with every kind of column."""

    arm: str
    share: float
    count: int
    some: int | None
    known: bool | None
    said: str | None


@dataclass(frozen=True)
class Counted:
    """A row without an arm."""

    count: int


class Word(StrEnum):
    """A column of one of some words."""

    ONE = "one"
    TWO = "two"


@dataclass(frozen=True)
class Wide:
    """A row with every kind of column of a data frame, one that may be a count or a truth value included."""

    word: Word
    said: str | None
    p: float | None
    count: int
    some: int | None
    known: bool
    either: int | bool | None


WIDE = [Wide(Word.ONE, "b,c", 1.5e-9, 3, None, True, 1), Wide(Word.TWO, None, None, -7, 8, False, None)]
HEADER = "share,arm,count,some,known,said,further\n"


def read(tmp_path, text, arms=None):
    path = tmp_path / "rows.csv"
    path.write_text(text, encoding="utf-8")
    return read_rows(path, Row, arms)


@pytest.mark.parametrize("name", ["static_outcomes", "embodied_outcomes", "static_rates", "significance"])
def test_rows_without_data_frames_are_those_with(name):
    kind = {"static_outcomes": StaticOutcome, "embodied_outcomes": EmbodiedOutcome, "static_rates": Rate}.get(name, Comparison)
    path = DATA / "metrics" / f"{name}.csv"
    with_frames = rows_of(kind, typed(pd.read_csv(path, dtype=str, keep_default_na=False), kind))
    assert read_rows(path, kind) == with_frames and len(with_frames) > 100


def test_a_column_is_found_by_its_name_and_what_may_be_empty_is_none(tmp_path):
    text = HEADER + '0.5,a,3,,1,"b,c",x\n-1e-3,b,0,7,0,,\n'
    assert read(tmp_path, text) == [Row("a", 0.5, 3, None, True, "b,c"), Row("b", -0.001, 0, 7, False, None)]


def test_only_rows_of_the_arms_are_read(tmp_path):
    """What another arm's row holds is not looked at."""
    text = HEADER + "0.5,a,3,,,,\nmany,b,,,,,\n1,c,1,,,,\n"
    assert [row.arm for row in read(tmp_path, text, {"a", "c"})] == ["a", "c"] and read(tmp_path, text, ()) == []


def test_rows_that_are_of_no_arm_are_read(tmp_path):
    (tmp_path / "counts.csv").write_text("count\n3\n", encoding="utf-8")
    assert read_rows(tmp_path / "counts.csv", Counted) == [Counted(3)]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("share,arm\n", r"no column count, there are share, arm; make the metrics again"),
        ("", r"no column arm, there are ; make the metrics again"),
        (HEADER + "many,a,3,,,,\n", "share is 'many', which is no finite number; make the metrics again"),
        (HEADER + "inf,a,3,,,,\n", "share is 'inf', which is no finite number; make the metrics again"),
        (HEADER + ",a,3,,,,\n", "share is '', which is no finite number; make the metrics again"),
        (HEADER + "1,a,2.5,,,,\n", "count is '2.5', which is no whole number; make the metrics again"),
        (HEADER + "1,a,2,x,,,\n", "some is 'x', which is no finite number; make the metrics again"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path, text, said):
    with pytest.raises(ValueError) as caught:
        read(tmp_path, text)
    assert str(caught.value) == f"{tmp_path / 'rows.csv'}: {said}"


def test_a_data_frame_has_a_type_for_each_column_and_gives_its_rows_back():
    kinds = {"word": "str", "said": "str", "p": "float64", "count": "int64", "some": "Int64", "known": "Int64", "either": "Int64"}
    frame = frame_of(Wide, WIDE)
    assert dtypes(Wide) == kinds == {name: str(kind) for name, kind in frame.dtypes.items()}
    assert rows_of(Wide, frame) == WIDE
    assert [[type(value) for value in vars(row).values()] for row in rows_of(Wide, frame)] == [
        [Word, str, float, int, type(None), bool, int],
        [Word, type(None), type(None), int, int, bool, type(None)],
    ]


def test_a_file_of_rows_is_read_as_the_rows_that_were_written(tmp_path):
    path = tmp_path / "rows.csv"
    write(path, Wide, WIDE)
    frame = frames.read(path, Wide)
    assert {name: str(kind) for name, kind in frame.dtypes.items()} == dtypes(Wide) and rows_of(Wide, frame) == WIDE


def test_a_frame_that_has_a_column_twice_gives_no_rows():
    frame = frame_of(Counted, [Counted(3)])
    with pytest.raises(ValueError, match="longer"):
        rows_of(Counted, pd.concat([frame, frame], axis=1))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ({"count": ["2", ""]}, "count is empty in a row; make the metrics again"),
        ({"count": ["many"]}, "count is 'many', which is no finite number; make the metrics again"),
        ({"count": ["inf"]}, "count is 'inf', which is no finite number; make the metrics again"),
        ({"count": ["2.5"]}, "count is '2.5', which is no whole number; make the metrics again"),
        ({"counts": ["2"]}, "no column count, there are counts; make the metrics again"),
    ],
)
def test_a_frame_of_text_that_cannot_be_read_is_one_line(text, said):
    with pytest.raises(ValueError) as caught:
        typed(pd.DataFrame(text), Counted)
    assert str(caught.value) == said


def test_a_part_of_one_is_no_count_where_there_may_be_none():
    with pytest.raises(ValueError) as caught:
        typed(pd.DataFrame({"some": ["", "3", "0.5"]}), Perhaps)
    assert str(caught.value) == "some is '0.5', which is no whole number; make the metrics again"


@dataclass(frozen=True)
class Perhaps:
    """A row of a count, or of none."""

    some: int | None


@dataclass(frozen=True)
class Number:
    """A row of one number."""

    share: float


@pytest.mark.parametrize(
    ("value", "text"),
    [(-4e-7, "0.000000"), (-0.0, "0.000000"), (-6e-7, "-0.000001"), (0.1234565, "0.123456"), (2.0 / 3.0, "0.666667")],
)
def test_a_number_has_six_decimals_and_none_has_a_lone_sign(value, text):
    assert csv_text(Number, [Number(value)]) == f"share\n{text}\n"


def test_a_file_of_rows_ends_each_line_with_a_line_feed_on_every_system(monkeypatch):
    monkeypatch.setattr(os, "linesep", "\r\n")
    assert csv_text(Wide, WIDE) == ('word,said,p,count,some,known,either\none,"b,c",1.5e-09,3,,1,1\ntwo,,,-7,8,0,\n')
