"""Tables of arms with several runs, of a task of an agent's own, of seeds and of scenes, from metrics as the stage makes them."""

from __future__ import annotations

import pytest

from ovman.analysis.dualmap_objects import ALL, Objects
from ovman.analysis.own_task import OwnTask, own_task
from ovman.analysis.pairings import Pairing, pairings
from ovman.analysis.rates import Rate, embodied_rates, static_rates
from ovman.analysis.scenes import SceneRate, scenes
from ovman.analysis.spread import Pass, passes
from ovman.report.tables.dualmap import dualmap_table
from ovman.report.tables.own_task import own_task_table
from ovman.report.tables.rates import embodied_table, static_table
from ovman.report.tables.scenes import scenes_table
from ovman.report.tables.seeds import seeds_table
from ovman.report.tables.significance import pairings_table
from ovman.report.tables.table import SECTION, latex, markdown
from ovman.report.tables.table import csv_text as table_csv
from ovman.settings import Kind, Source
from ovman.settings.arms import ArmJob
from tests.analysis.fabricated import embodied, static
from tests.arms import CONFIG
from tests.report.reading import data, rows, settings

N = 24
MAINTAINED, TWICE, OURS = "dualmap_maintained", "dualmap_two_visits", "two_visits"
HANDED = f"grounding_{MAINTAINED}"
ARMS = (
    ArmJob(name=MAINTAINED, kind=Kind.STATIC, agent="x:y", system="DualMap", memory="maintained map", runs=3),
    ArmJob(name=TWICE, kind=Kind.STATIC, agent="x:y", system="DualMap", memory="two visits", runs=3),
    ArmJob(name=OURS, kind=Kind.STATIC, agent="x:y", system="reference agent", memory="two visits"),
    ArmJob(
        name=HANDED,
        kind=Kind.STATIC,
        agent="x:y",
        system="DualMap",
        memory="maintained map",
        grounding=Source.HANDED,
        runs=3,
    ),
    ArmJob(name="cow", kind=Kind.EMBODIED, agent="x:y", system="CoW", memory="second visit"),
    ArmJob(name="oracle_check", kind=Kind.EMBODIED, agent="x:y", system="oracle check", memory="the answer"),
)
SETTINGS = settings(ARMS)
PAIRINGS = tuple(CONFIG.comparisons.pairings.values())
STATIC = [
    *(static(MAINTAINED, i, i < 3 + run, seed=run, scene=f"FloorPlan{1 + i % 2}") for run in range(3) for i in range(N)),
    *(static(TWICE, i, 4 <= i < 9 - run, seed=run, scene=f"FloorPlan{1 + i % 2}") for run in range(3) for i in range(N)),
    *(static(OURS, i, i % 2 == 0, scene=f"FloorPlan{1 + i % 2}") for i in range(N)),
    *(static(HANDED, i, 0.25 * run, "expected", seed=run, scene=f"FloorPlan{1 + i % 2}") for run in range(3) for i in range(N)),
]
EMBODIED = [
    *(
        embodied("cow", i, i < 2 + seed, seed, own_success=1 <= i < 8, scene=f"FloorPlan{1 + i % 2}")
        for seed in (0, 1)
        for i in range(N)
    ),
    *(embodied("oracle_check", i, True, seed, scene=f"FloorPlan{1 + i % 2}") for seed in (0, 1) for i in range(N)),
]


@pytest.fixture(scope="module")
def tables():
    made = [
        static_table(rows(Rate, static_rates(STATIC, 0.95)), SETTINGS),
        embodied_table(rows(Rate, embodied_rates(EMBODIED, 0.95)), SETTINGS),
        pairings_table(rows(Pairing, pairings(STATIC, PAIRINGS)[0]), SETTINGS),
        own_task_table(rows(OwnTask, own_task(EMBODIED)), SETTINGS),
        seeds_table(rows(Pass, passes(STATIC, EMBODIED)), SETTINGS),
        scenes_table(rows(SceneRate, scenes(STATIC, EMBODIED, 0.95)), SETTINGS),
    ]
    return dict(zip(("static", "embodied", "pairings", "own_task", "seeds", "scenes"), made, strict=True))


def test_every_table_has_every_format(tables):
    for name, table in tables.items():
        assert latex(table, name).isascii() and rf"\label{{tab:{name}}}" in latex(table, name)
        assert len({len(line) for line in markdown(table).split("\n\n")[1].splitlines()}) == 1
        assert all(mark not in table_csv(table) for mark in "†—–")


def test_runs_are_means_and_the_page_says_so(tables):
    maintained, twice, ours, handed = data(tables["static"])
    assert [maintained[key] for key in ("system", "all", "all_min", "all_max", "runs", "n")] == [
        "DualMap", "0.167", "0.125", "0.208", "3", "24",
    ]  # fmt: skip
    assert (ours["runs"], ours["all_min"], ours["all_max"]) == ("1", "", "")
    assert (handed["all"], handed["interval"], twice["interval"]) == ("0.250", "poisson_binomial", "wilson")
    caption = " ".join(markdown(tables["static"]).split("\n\n")[0].split())
    assert "runs add no episodes" in caption


def test_what_is_handed_over_is_one_block_whatever_the_order_of_the_arms():
    table = static_table(rows(Rate, static_rates(STATIC, 0.95)), settings(ARMS[::-1]))
    assert [row["memory"] for row in data(table)] == ["two visits", "two visits", "maintained map", "maintained map"]
    assert latex(table, "static").count("oracle grounding") == 1
    assert [*table.rows[SECTION]] == [""] * 3 + ["oracle grounding (diagnostic)"]


def test_an_arm_with_a_body_of_its_own_has_its_spl(tables):
    cow, oracle = data(tables["embodied"])
    assert (cow["agent"], cow["sr"], cow["spl"], cow["seeds"]) == ("CoW", "0.104", "0.094", "2")
    assert oracle["sr"] == "1.000"


def test_worst_and_best_pairing(tables):
    whole = {(row["arm"], row["baseline"]): row for row in data(tables["pairings"]) if row["relation"] == "ALL"}
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
    made = pairings_table(rows(Pairing, pairings([*STATIC, *outcomes], PAIRINGS)[0]), SETTINGS)
    whole = {(row["arm"], row["baseline"]): row for row in data(made) if row["relation"] == "ALL"}
    of_pick = whole[f"grounding_{TWICE}", HANDED]
    assert (of_pick["test"], of_pick["pairings"], of_pick["best"], of_pick["best_p"]) == ("poisson_binomial", "6", "+1.000", "0")
    assert "; 0: it cannot." in " ".join(markdown(made).split("\n\n")[0].split())


def test_the_own_task_beside_this_one(tables):
    *_, whole = data(tables["own_task"])
    shown = ("agent", "relation", "own", "rate", "rate_min", "rate_max", "gap", "only_own", "only_here")
    assert [whole[key] for key in shown] == [
        "CoW", "ALL", "0.292", "0.104", "0.083", "0.125", "+0.188", "6, 5", "1, 1",
    ]  # fmt: skip
    assert float(whole["own_low"]) < 0.292 < float(whole["own_high"]) and float(whole["p"]) == 0.21875
    assert "0.104 (0.083–0.125)" in markdown(tables["own_task"])
    assert {row["agent"] for row in data(tables["own_task"])} == {"CoW"}


def test_seeds_of_the_arms_that_have_several(tables):
    found = {row["arm"]: row for row in data(tables["seeds"])}
    assert list(found) == [MAINTAINED, TWICE, HANDED, "cow", "oracle_check"]
    assert [found[TWICE][key] for key in ("each", "mean", "all_min", "all_max", "spread")] == [
        "0.208, 0.167, 0.125", "0.167", "0.125", "0.208", "0.083",
    ]  # fmt: skip
    assert found["oracle_check"]["spread"] == "0.000"


def test_scenes_of_every_arm(tables):
    found = {row["arm"]: row for row in data(tables["scenes"])}
    assert list(found) == [arm.name for arm in ARMS]
    assert [found[OURS][key] for key in ("worst", "worst_n", "worst_rate", "best", "best_rate", "never", "scenes")] == [
        "FloorPlan2", "12", "0.000", "FloorPlan1", "1.000", "1", "2",
    ]  # fmt: skip
    assert (found[OURS]["FloorPlan1"], found[OURS]["FloorPlan2"]) == ("1.000", "0.000")


def test_objects_of_dualmaps_maps():
    made = [
        Objects(ALL, "two visits", ALL, 6, 100.0, 20.0, 2, 40),
        *(Objects("FloorPlan1", "two visits", run, 1, 90.0, 4.0 + run, 4 + run, 4 + run) for run in (0, 1)),
        *(Objects("FloorPlan2", "two visits", run, 2, 105.0, 27.75 - run, 2, 40) for run in (0, 1)),
    ]
    table = dualmap_table(rows(Objects, made), SETTINGS)
    shown = ("scene", "runs", "maps", "frames", "objects", "objects_min", "objects_max")
    assert [[row[key] for key in shown] for row in data(table)] == [
        [ALL, "2", "6", "100.0", "20.0", "2", "40"],
        ["FloorPlan1", "2", "2", "90.0", "4.5", "4", "5"],
        ["FloorPlan2", "2", "4", "105.0", "27.2", "2", "40"],
    ]  # fmt: skip
    assert latex(table, "dualmap").isascii() and markdown(table)


def test_without_baselines_the_tables_are_empty():
    for kind, make in (
        (Pairing, pairings_table),
        (OwnTask, own_task_table),
        (Pass, seeds_table),
        (SceneRate, scenes_table),
        (Objects, dualmap_table),
    ):
        table = make(rows(kind, []), SETTINGS)
        assert len(table_csv(table).splitlines()) == 1 and markdown(table) and latex(table, "empty")
