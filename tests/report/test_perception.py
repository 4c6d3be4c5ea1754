from __future__ import annotations

from dataclasses import replace

import pytest

from ovman.analysis.localisation import Localised
from ovman.analysis.scores import ALL, CATEGORIES, SCENE, SIZE, Score
from ovman.report.tables.backprojection import backprojection_table
from ovman.report.tables.perception import bars, perception_table
from ovman.report.tables.table import csv_text as table_csv
from ovman.report.tables.table import latex, markdown
from tests.report.reading import data, rows, settings

GOOD = Score(
    ALL, ALL, true=100, recalled=75, recall=0.75, found=90, right=68, precision=0.78, doubled=2, precision_once=0.75,
    crops=68, top1=0.6, top5=0.88,
    chance_top1=0.05, chance_top5=0.25, named=60, own_top1=0.62, own_top5=0.9, synonym_top1=0.52, synonym_top5=0.8,
)  # fmt: skip


def test_what_reaches_a_bar_meets_it():
    assert {name: bar.verdict for name, bar in bars([GOOD]).items()} == dict.fromkeys(
        ("recall", "precision", "precision_once", "top1", "top5", "synonym_top1", "synonym_top5"), "met"
    )


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("recall", 0.7499),
        ("precision", 0.7499),
        ("precision", None),
        ("precision_once", 0.7499),
        ("top1", 0.5999),
        ("top5", 0.8799),
        ("synonym_top1", 0.5199),
    ],
)
def test_what_misses_a_bar_is_said_to(name, value):
    found = bars([replace(GOOD, **{name: value})])
    assert [rate for rate, bar in found.items() if not bar.met] == [name]


def test_synonyms_are_measured_against_the_own_nouns_of_the_same_crops():
    assert not bars([replace(GOOD, own_top1=0.63)])["synonym_top1"].met


def test_the_table_shows_bars_and_groups():
    scores = [
        GOOD,
        Score(CATEGORIES, "mean", recall=0.5, top1=0.4, top5=0.8),
        replace(GOOD, group=SIZE, value="below 600 px"),
        replace(GOOD, group=SCENE, value="FloorPlan1", precision=None, found=0),
        replace(GOOD, group="category", value="Sofa"),
    ]
    table = perception_table(rows(Score, scores), settings())
    assert [*table.rows["which"]] == [
        "all", "mean over categories", "chance", "bar", "verdict", "below 600 px", "FloorPlan1",
    ]  # fmt: skip
    text = markdown(table)
    assert "≥ 0.750" in text and "met" in text and "300 px" in text and "0.25" in text
    assert r"$\ge$ 0.750" in latex(table, "perception") and table_csv(table).startswith("of,which,true,recall")


def test_a_file_without_its_first_row_is_refused():
    with pytest.raises(ValueError, match="no row of all"):
        bars([replace(GOOD, group=SCENE)])


def test_objects_count_by_their_worst_mask():
    def mask(thing, view, kind, error):
        return Localised("FloorPlan1", thing, "Sofa", view, kind, 400, 0.0, error, error, error)

    masks = [("a", 0, "true", 1.0), ("a", 1, "true", 3.0), ("b", 0, "true", 2.0), ("a", 0, "detected", 9.0)]
    table = backprojection_table(rows(Localised, [mask(*one) for one in masks]), settings())
    of = {(row["mask"], row["estimate"].split()[0], row["unit"]): row for row in data(table)}
    assert of["true", "single", "masks"]["n"] == "3" and of["true", "single", "objects"]["n"] == "2"
    assert of["true", "single", "masks"]["box_median"] == "2.0000"
    assert of["true", "single", "objects"]["box_median"] == "2.5000"
    assert of["true", "component-wise", "masks"]["box_max"] == "0.0000"
    assert of["detected", "single", "objects"]["box_max"] == "9.0000"
    assert "single ray" in markdown(table) and "median" in latex(table, "backprojection")
