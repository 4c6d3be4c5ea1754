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
from scipy.stats import binom

from ovman.analysis import breakdowns, comparisons, navigation
from ovman.analysis.backprojection import BACKPROJECTION
from ovman.analysis.perception import PerceptionScore
from ovman.analysis.rates import RATES, arm_rates
from ovman.analysis.registry import all_tables, paper_tables
from ovman.analysis.rows import csv_text
from ovman.report.tables import TABLES
from ovman.report.tables.benchmark import CONSTANTS, constants_table, value_text
from ovman.report.tables.columns import count, p_value, power_of_ten, signed
from ovman.report.tables.perception import bars
from ovman.report.tables.table import ALL, Table, latex, make_table, markdown, read_metrics, type_metrics
from ovman.report.tables.table import csv_text as table_csv
from ovman.task import Relation
from tests.analysis.fabricated import embodied, static
from tests.arms import CONFIG
from tests.episodes import DATA


def shown(name, columns, rows, settings=CONFIG) -> Table:
    """Make a table from rows as a file of metrics has them."""
    text = pd.read_csv(io.StringIO(csv_text(columns, rows)), dtype=str, keep_default_na=False)
    return make_table(TABLES[name], type_metrics(text), settings)


def data(table):
    return list(csv.DictReader(io.StringIO(table_csv(table))))


def caption(table):
    return " ".join(markdown(table).split("\n\n")[0].split())


def with_arms(arms):
    return CONFIG.model_copy(update={"arms": {arm.name: arm for arm in arms}})


N = 24
MAINTAINED, TWICE, OURS = "dualmap_maintained", "dualmap_two_visits", "two_visits"
HANDED = f"grounding_{MAINTAINED}"
PAIRINGS = tuple(CONFIG.comparisons.pairings.values())
STATIC = [
    *(static(MAINTAINED, i, i < 3 + run, seed=run, scene=f"FloorPlan{1 + i % 2}") for run in range(3) for i in range(N)),
    *(static(TWICE, i, 4 <= i < 9 - run, seed=run, scene=f"FloorPlan{1 + i % 2}") for run in range(3) for i in range(N)),
    *(static(OURS, i, i % 2 == 0, scene=f"FloorPlan{1 + i % 2}") for i in range(N)),
    *(static(HANDED, i, 0.25 * run, "expected", seed=run, scene=f"FloorPlan{1 + i % 2}") for run in range(3) for i in range(N)),
]


def test_what_is_handed_over_is_one_block_whatever_the_order_of_the_arms():
    table = shown(
        "static_rates",
        RATES,
        arm_rates(STATIC, 0.95),
        with_arms([CONFIG.arms[name] for name in (HANDED, OURS, TWICE, MAINTAINED)]),
    )
    assert [row["memory"] for row in data(table)] == ["two visits", "two visits", "maintained map", "maintained map"]
    assert latex(table, "static").count("oracle grounding") == 1
    assert [*table.sections] == [""] * 3 + ["oracle grounding (diagnostic)"]


def pairings_over_all(outcomes) -> tuple[Table, dict[tuple[str, str], dict[str, str]]]:
    table = shown("pairings", comparisons.PAIRINGS, comparisons.pairings(outcomes, PAIRINGS))
    return table, {(row["arm"], row["baseline"]): row for row in data(table) if row["relation"] == "ALL"}


def test_worst_and_best_pairing():
    _, whole = pairings_over_all(STATIC)
    readings = whole[TWICE, MAINTAINED]
    # Runs have 5, 4 and 3 successes, against 3, 4 and 5.
    assert [readings[key] for key in ("pairings", "difference", "worst", "worst_runs", "best", "best_runs")] == [
        "9", "+0.000", "-0.083", "2-2", "+0.083", "0-0",
    ]  # fmt: skip
    assert (readings["worst_wins"], readings["worst_losses"]) == ("2", "4")
    assert whole[OURS, MAINTAINED]["pairings"] == whole[OURS, TWICE]["pairings"] == "3"
    assert whole[OURS, MAINTAINED]["worst"] == "+0.292"


def test_a_pick_that_cannot_succeed_so_often_is_told():
    outcomes = [static(f"grounding_{TWICE}", i, 1.0, seed=run, scene=f"FloorPlan{1 + i % 2}") for run in (0, 1) for i in range(N)]
    made, whole = pairings_over_all([*STATIC, *outcomes])
    of_pick = whole[f"grounding_{TWICE}", HANDED]
    assert (of_pick["test"], of_pick["pairings"], of_pick["best"], of_pick["best_p"]) == ("poisson_binomial", "6", "+1.000", "0")
    assert "; 0: it cannot." in caption(made)


ANSWERS = [
    *(static("single_visit", i, 0.25, "expected", instances=2 + i % 4) for i in range(N)),
    *(
        static("two_visits", i, i < 12, instances=2 + i % 4, **({"distance_m": 1.5} if i == 12 else {}))
        if i < 18
        else static("two_visits", i, False, "abstained", instances=2 + i % 4)
        for i in range(N)
    ),
]
DRIVES = [
    *(embodied("single_visit_embodied", i, i == 3, seed) for seed in (0, 1) for i in range(N)),
    *(embodied("two_visits_embodied", i, seed < i < 16, seed) for seed in (0, 1) for i in range(N)),
]


@pytest.fixture(scope="module")
def tests():
    compared = comparisons.significance([*ANSWERS, *DRIVES], CONFIG.comparisons.pairs.values())
    lost = navigation.navigation(ANSWERS, DRIVES, CONFIG.arms, CONFIG.success.radius_m)
    return {
        "taxonomy": shown("taxonomy", breakdowns.TAXONOMY, breakdowns.taxonomy(ANSWERS, lost, 1.0, 2.0)),
        "significance": shown("significance", comparisons.COMPARISONS, compared),
    }


def test_the_rows_of_the_taxonomy_partition_the_episodes(tests):
    *verdicts, episodes, lost = data(tests["taxonomy"])
    assert [row["outcome"] for row in verdicts] == ["success", "abstain", "elsewhere", "near miss", "wrong instance"]
    assert [row["all"] for row in (*verdicts, episodes, lost)] == ["12", "6", "5", "1", "0", "24", "1"]
    for relation in ("moved", "former", "moving", "stable", "appeared", "removed", "all"):
        assert sum(int(row[relation]) for row in verdicts) == int(episodes[relation])
        assert int(lost[relation]) <= int(verdicts[0][relation])
    assert "partition the 24 episodes" in caption(tests["taxonomy"])
    assert "under seed 0 (in all 2 under seed 1)" in caption(tests["taxonomy"])


def test_a_taxonomy_that_does_not_add_up_is_not_printed():
    rows = breakdowns.taxonomy(ANSWERS, [], 1.0, 2.0)
    for row in rows:
        row["episodes"] += (row["arm"], row["verdict"], row["relation"]) == ("two_visits", "abstain", "stable")
    with pytest.raises(ValueError, match="verdicts on stable add up to 5 of 4 episodes"):
        shown("taxonomy", breakdowns.TAXONOMY, rows)


def test_tests_show_all_relations_of_one_seed_and_the_whole_of_the_others(tests):
    rows = data(tests["significance"])
    others = [row for row in rows if row["seed"] != "0"]
    assert [[row[key] for key in ("arm", "seed", "relation", "wins", "losses")] for row in others] == [
        ["two_visits_embodied", "1", "ALL", "13", "0"]
    ]
    assert float(others[0]["p"]) == pytest.approx(2 * 0.5**13, rel=1e-5)
    whole = {row["arm"]: row for row in rows if row["relation"] == "ALL" and row["seed"] == "0"}
    assert [whole["two_visits"][key] for key in ("successes", "baseline_successes", "wins", "losses", "test")] == [
        "12", "6.0", "9.0", "3.0", "poisson_binomial",
    ]  # fmt: skip
    assert float(whole["two_visits"]["p"]) == pytest.approx(binom.sf(11, 24, 0.25), rel=1e-5)
    assert [whole["two_visits_embodied"][key] for key in ("wins", "losses", "p_holm")] == ["14", "0", ""]
    assert "p = 0" not in caption(tests["significance"])


FILES = {name.rpartition("/")[2]: name for name in (*paper_tables(CONFIG), *all_tables(CONFIG))}


@pytest.mark.parametrize("name", sorted({*FILES} - {"perception", "rejections"}))
def test_metrics_without_rows_are_an_empty_table(name):
    table = make_table(TABLES[name], read_metrics(DATA / "metrics" / f"{FILES[name]}.csv").iloc[:0], CONFIG)
    assert {*FILES} == {*TABLES}
    assert len(table_csv(table).splitlines()) == 1 and markdown(table) and latex(table, "empty")


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


def test_objects_count_by_their_worst_mask():
    def mask(thing, view, kind, error):
        values = ("FloorPlan1", thing, "Sofa", view, kind, 400, 0.0, error, error, error)
        return dict(zip(BACKPROJECTION.split(), values, strict=True))

    masks = [("a", 0, "true", 1.0), ("a", 1, "true", 3.0), ("b", 0, "true", 2.0), ("a", 0, "detected", 9.0)]
    table = shown("backprojection", BACKPROJECTION, [mask(*one) for one in masks])
    of = {(row["mask"], row["estimate"].split()[0], row["unit"]): row for row in data(table)}
    assert of["true", "single", "masks"]["n"] == "3" and of["true", "single", "objects"]["n"] == "2"
    assert of["true", "single", "masks"]["box_median"] == "2.0000"
    assert of["true", "single", "objects"]["box_median"] == "2.5000"
    assert of["true", "component-wise", "masks"]["box_max"] == "0.0000"
    assert of["detected", "single", "objects"]["box_max"] == "9.0000"


REJECTIONS = "relation,stage,reason,count\n" + "".join(
    f"{relation},drawn,,9\n{relation},placement,placement_refused,{3 if relation == 'moved' else 2}\n"
    f"{relation},certification,certification_failed,{0 if relation == 'moved' else 1}\n"
    f"{relation},certified,,6\n{relation},released,,{5 if relation == 'moved' else 6}\n"
    for relation in (relation.value for relation in Relation)
)


def test_a_relation_without_episodes_is_empty_not_zero():
    rows = [row for row in arm_rates(STATIC, 0.95) if row.relation != "stable"]
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
