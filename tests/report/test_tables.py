"""Tables from metrics as the stages write them: every cell by hand, every format, and metrics that contradict themselves."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from functools import reduce
from types import SimpleNamespace

import pandas as pd
import pytest

from ovman.agents.interface import Answer
from ovman.analysis import breakdowns
from ovman.analysis.outcomes import static_outcomes
from ovman.analysis.perception import PerceptionScore
from ovman.analysis.rates import RATES, arm_rates
from ovman.analysis.registry import all_tables, paper_tables
from ovman.analysis.rows import csv_text
from ovman.language.phrases import SOURCES
from ovman.records.prediction import Prediction
from ovman.report.tables import TABLES
from ovman.report.tables.benchmark import CONSTANTS, constants_table, value_text
from ovman.report.tables.columns import count, p_value, power_of_ten, signed
from ovman.report.tables.perception import bars
from ovman.report.tables.table import ALL, Table, latex, make_table, markdown, read_metrics, type_metrics
from ovman.report.tables.table import csv_text as table_csv
from ovman.task import Relation
from tests.analysis.fabricated import static
from tests.arms import CONFIG
from tests.episodes import DATA, released


def shown(name, columns, rows, settings=CONFIG) -> Table:
    """Make a table from rows as a file of metrics has them."""
    text = pd.read_csv(io.StringIO(csv_text(columns, rows)), dtype=str, keep_default_na=False)
    return make_table(TABLES[name], type_metrics(text), settings)


def data(table):
    return list(csv.DictReader(io.StringIO(table_csv(table))))


ANSWERS = [static("two_visits", i, i % 2, "answered" if i < 18 else "abstained") for i in range(24)]


def test_a_taxonomy_that_does_not_add_up_is_not_printed():
    rows = breakdowns.taxonomy(ANSWERS, [], 1.0, 2.0)
    for row in rows:
        row["episodes"] += (row["arm"], row["verdict"], row["relation"]) == ("two_visits", "abstain", "stable")
    with pytest.raises(ValueError, match="verdicts on stable add up to 5 of 4 episodes"):
        shown("taxonomy", breakdowns.TAXONOMY, rows)


FILES = {name.rpartition("/")[2]: name for name in (*paper_tables(CONFIG), *all_tables(CONFIG))}


@pytest.mark.parametrize("name", sorted({*FILES} - {"perception", "rejections", "bounds", "words"}))
def test_metrics_without_rows_are_an_empty_table(name):
    table = make_table(TABLES[name], read_metrics(DATA / "metrics" / f"{FILES[name]}.csv").iloc[:0], CONFIG)
    assert {*FILES} == {*TABLES}
    assert len(table_csv(table).splitlines()) == 1 and markdown(table) and latex(table, "empty")


def test_the_words_track_stands_next_to_the_paper_s_by_the_source_of_the_phrase():
    some = [one for one in released() if one.category == "Chair"][:8]
    answers = [Prediction.of(one.id, "joint", 0, Answer(*one.answer)) for one in some]
    answers += [Prediction.of(one.id, "joint_words", 0, Answer(99.0, 99.0)) for one in some]
    rows = breakdowns.words(static_outcomes(some, answers, radius_m=1.0), some, CONFIG.arms, 0.95)
    table = shown("words", breakdowns.WORDS, rows)
    (row,) = data(table)
    assert (row["n_all"], row["paper_all"], row["words_all"]) == ("8", "1.000", "0.000")
    assert sum(int(row[f"n_{source}"] or 0) for source in SOURCES) == 8
    assert "joint agent, words" in markdown(table) and latex(table, "words")
    assert not data(shown("words", breakdowns.WORDS, []))


def test_p_values_keep_their_size():
    assert [p_value(value) for value in (1.0, 0.05049, 0.001, 4.42860e-41, 0.00099, 0.0)] == [
        "1.000", "0.050", "0.001", "4.4e-41", "9.9e-4", "0",
    ]  # fmt: skip
    assert [power_of_ten(text) for text in ("4.4e-41", "0.050")] == [r"$4.4\times10^{-41}$", "0.050"]
    assert (count(3.0), count(40.75, expected=True), signed(-0.0125)) == ("3", "40.8", "-0.013")


GOOD = PerceptionScore(
    ALL, ALL, true=100, recalled=75, recall=0.75, found=90, right=68, precision=0.78, doubled=2, precision_once=0.75,
    crops=68, top1=0.6, top5=0.88,
    chance_top1=0.05, chance_top5=0.25, named=60, own_top1=0.62, own_top5=0.9, synonym_top1=0.52, synonym_top5=0.8,
)  # fmt: skip


@pytest.mark.parametrize(
    ("change", "missed"),
    [
        ({}, []),
        ({"recall": 0.7499}, ["recall"]),
        ({"precision": None}, ["precision"]),
        ({"top5": 0.8799}, ["top5"]),
        ({"synonym_top1": 0.5199}, ["synonym_top1"]),
        ({"own_top1": 0.63}, ["synonym_top1"]),  # measured against the own nouns of the same crops
    ],
)
def test_what_misses_a_bar_is_said_to(change, missed):
    assert [rate for rate, bar in bars([replace(GOOD, **change)]).items() if bar.verdict != "met"] == missed


REJECTIONS = "relation,stage,reason,count\n" + "".join(
    f"{relation},drawn,,9\n{relation},placement,placement_refused,{3 if relation == 'moved' else 2}\n"
    f"{relation},certification,certification_failed,{0 if relation == 'moved' else 1}\n"
    f"{relation},certified,,6\n{relation},released,,{5 if relation == 'moved' else 6}\n"
    for relation in (relation.value for relation in Relation)
)


def test_a_relation_without_episodes_is_empty_not_zero():
    rows = [row for row in arm_rates(ANSWERS, 0.95) if row.relation != "stable"]
    table = shown("static_rates", RATES, rows)
    assert all(row["stable"] == row["stable_low"] == "" for row in data(table)) and " — |" in markdown(table)


@pytest.mark.parametrize(
    "change",
    [
        ("moved,drawn,,9", "moved,drawn,,10"),
        ("moved,released,,5", "moved,released,,7"),
        ("former,drawn,,9", "moved,drawn,,9"),
        ("former,drawn,,9", "vanished,drawn,,9"),
    ],
)
def test_an_audit_that_contradicts_itself_is_not_printed(change):
    text = pd.read_csv(io.StringIO(REJECTIONS.replace(*change)), dtype=str, keep_default_na=False)
    with pytest.raises(ValueError, match="add up|duplicate"):
        make_table(TABLES["rejections"], type_metrics(text), CONFIG)


def test_an_audit_without_a_rejection_shows_the_totals_alone():
    counts = "relation,stage,reason,count\n" + "".join(f"moved,{stage},,2\n" for stage in ("drawn", "certified", "released"))
    text = pd.read_csv(io.StringIO(counts), dtype=str, keep_default_na=False)
    rows = data(make_table(TABLES["rejections"], type_metrics(text), CONFIG))
    assert [(row["stage"], row["moved"], row["all"]) for row in rows] == [
        (s, "2", "2") for s in ("drawn", "certified", "released")
    ]


def namespace(value):
    return SimpleNamespace(**{key: namespace(member) for key, member in value.items()}) if isinstance(value, dict) else value


def test_constants_are_those_in_force():
    keys = [constant[0] for constant in CONSTANTS]
    assert len(set(keys)) == len(keys)
    constants = namespace(json.loads(CONFIG.model_dump_json(exclude={"arms", "splits", "comparisons", "paper"})))
    before = {row["setting"]: row for row in data(constants_table(constants))}
    assert list(before) == keys
    for key in keys:
        *sections, name = key.split(".")
        section = reduce(getattr, sections, constants)
        value = getattr(section, name)
        setattr(section, name, [*value, 75] if isinstance(value, list) else value + 3)
        after = {row["setting"]: row for row in data(constants_table(constants))}
        assert {other for other in keys if after[other] != before[other]} == {key}
        setattr(section, name, value)


def test_metres_have_a_decimal_however_they_are_written():
    assert value_text(2, "m") == value_text(2.0, "m") == "2.0"
    assert value_text(30, "°") == value_text(30.0, "°") == "30" and value_text([0, 30], "°") == "0, 30"
