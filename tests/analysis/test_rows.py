"""Rows of metrics read without data frames."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd
import pytest

from ovman.analysis.frames import rows_of, typed
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
