"""Tables of failures, tests, navigation, difficulty and budget, from metrics made up and written by the stage itself."""

from __future__ import annotations

import pytest
from scipy.stats import binom

from ovman.analysis.budget import Step, budget
from ovman.analysis.difficulty import Difficulty, difficulty
from ovman.analysis.navigation import Navigation, navigation
from ovman.analysis.rates import static_rates
from ovman.analysis.significance import Comparison, significance
from ovman.analysis.taxonomy import TaxonomyCount, taxonomy
from ovman.report.tables.budget import budget_table
from ovman.report.tables.columns import count, p_value, power_of_ten, signed
from ovman.report.tables.difficulty import difficulty_table
from ovman.report.tables.navigation import navigation_table
from ovman.report.tables.significance import significance_table
from ovman.report.tables.table import csv_text as table_csv
from ovman.report.tables.table import latex, markdown
from ovman.report.tables.taxonomy import taxonomy_table
from tests.analysis.fabricated import embodied, static
from tests.arms import ARMS, CONFIG
from tests.report.reading import data, rows, settings

N = 24
SETTINGS = settings()
STATIC = [
    *(static("single_visit", i, 0.25, "expected", instances=2 + i % 4) for i in range(N)),
    *(
        static("two_visits", i, i < 12, instances=2 + i % 4, **({"distance_m": 1.5} if i == 12 else {}))
        if i < 18
        else static("two_visits", i, False, "abstained", instances=2 + i % 4)
        for i in range(N)
    ),
    *(static("grounding_two_visits", i, i < 18, instances=2 + i % 4) for i in range(N)),
    *(static("positions_two_visits", i, i != 5, instances=2 + i % 4) for i in range(N)),
]
EMBODIED = [
    *(embodied("single_visit_embodied", i, i == 3, seed) for seed in (0, 1) for i in range(N)),
    *(embodied("two_visits_embodied", i, seed < i < 16, seed) for seed in (0, 1) for i in range(N)),
]


@pytest.fixture(scope="module")
def tables():
    compared, _ = significance(STATIC, EMBODIED, CONFIG.comparisons.pairs.values())
    navigations = navigation(STATIC, EMBODIED, ARMS)
    made = [
        taxonomy_table(rows(TaxonomyCount, taxonomy(STATIC, navigations, 1.0, 2.0)), SETTINGS),
        significance_table(rows(Comparison, compared), SETTINGS),
        navigation_table(rows(Navigation, navigations), SETTINGS),
        difficulty_table(rows(Difficulty, difficulty(STATIC, 0.95)), SETTINGS),
        budget_table(rows(Step, budget(static_rates(STATIC, 0.95), compared, CONFIG.comparisons.rungs)), SETTINGS),
    ]
    return dict(zip(("taxonomy", "significance", "navigation", "difficulty", "budget"), made, strict=True))


def test_every_table_has_every_format(tables):
    for name, table in tables.items():
        assert latex(table, name).isascii() and rf"\label{{tab:{name}}}" in latex(table, name)
        assert len({len(line) for line in markdown(table).split("\n\n")[1].splitlines()}) == 1
        assert all(mark not in table_csv(table) for mark in "†—–")


def test_the_rows_of_the_taxonomy_partition_the_episodes(tables):
    *verdicts, episodes, lost = data(tables["taxonomy"])
    assert [row["outcome"] for row in verdicts] == ["success", "abstain", "elsewhere", "near miss", "wrong instance"]
    assert [row["all"] for row in (*verdicts, episodes, lost)] == ["12", "6", "5", "1", "0", "24", "1"]
    for relation in ("moved", "former", "moving", "stable", "appeared", "removed", "all"):
        assert sum(int(row[relation]) for row in verdicts) == int(episodes[relation])
        assert int(lost[relation]) <= int(verdicts[0][relation])
    caption = markdown(tables["taxonomy"]).split("\n\n")[0].replace("\n", " ")
    assert "partition the 24 episodes" in caption and "under seed 0 (in all 2 under seed 1)" in caption
    tex = latex(tables["taxonomy"], "taxonomy").splitlines()
    assert tex[tex.index(next(line for line in tex if line.startswith("episodes"))) - 1] == r"\midrule"
    assert r"\multicolumn{8}{l}{\emph{of success, no sixth outcome}} \\" in tex


def test_a_taxonomy_that_does_not_add_up_is_not_printed():
    counts = rows(TaxonomyCount, taxonomy(STATIC, [], 1.0, 2.0))
    of_agent = (counts["arm"] == "two_visits") & (counts["verdict"] == "abstain") & (counts["relation"] == "stable")
    counts.loc[of_agent, "episodes"] += 1
    with pytest.raises(ValueError, match="verdicts on stable add up to 5 of 4 episodes"):
        taxonomy_table(counts, SETTINGS)


def test_tests_show_all_relations_of_one_seed_and_the_whole_of_the_others(tables):
    shown = data(tables["significance"])
    others = [row for row in shown if row["seed"] != "0"]
    assert [[row[key] for key in ("arm", "seed", "relation", "wins", "losses")] for row in others] == [
        ["two_visits_embodied", "1", "ALL", "13", "0"]
    ]
    assert float(others[0]["p"]) == pytest.approx(2 * 0.5**13, rel=1e-5)
    whole = {row["arm"]: row for row in shown if row["relation"] == "ALL" and row["seed"] == "0"}
    assert [whole["two_visits"][key] for key in ("successes", "baseline_successes", "wins", "losses", "test")] == [
        "12", "6.0", "9.0", "3.0", "poisson_binomial",
    ]  # fmt: skip
    assert float(whole["two_visits"]["p"]) == pytest.approx(binom.sf(11, 24, 0.25), rel=1e-5)
    assert [whole["two_visits_embodied"][key] for key in ("wins", "losses", "p_holm")] == ["14", "0", ""]
    caption = markdown(tables["significance"]).split("\n\n")[0].replace("\n", " ")
    assert "p = 0" not in caption


def test_navigation_has_a_row_an_arm_and_a_count_a_seed(tables):
    one, two = data(tables["navigation"])
    assert (one["agent"], one["static"], one["lost"]) == ("reference agent, single visit", "0.250", "")
    assert [two[key] for key in ("static", "sr", "sr_min", "sr_max", "spl_given_success", "lost", "gained", "seeds")] == [
        "0.500", "0.604", "0.583", "0.625", "0.900", "1, 2", "4, 4", "0, 1",
    ]  # fmt: skip
    assert "0.250†" in markdown(tables["navigation"])


def test_difficulty_has_an_interval_beside_every_rate(tables):
    for row in data(tables["difficulty"]):
        for arm in ("single_visit", "two_visits", "grounding_two_visits", "positions_two_visits"):
            assert float(row[f"{arm}_low"]) <= float(row[arm]) <= float(row[f"{arm}_high"])
    assert [(row["by"], row["group"], row["n"]) for row in data(tables["difficulty"])] == [
        ("instances", "2", "6"), ("instances", "3", "6"), ("instances", "4+", "12"), ("scene", "FloorPlan1", "24"),
    ]  # fmt: skip


def test_the_budget_on_a_page(tables):
    table = markdown(tables["budget"]).split("\n\n")[1].splitlines()
    assert [[cell.strip() for cell in line.strip("|").split("|")] for line in table[2:]] == [
        ["own", "0.500", "0.314–0.686", "—", "—", "—", "—", "24"],
        ["oracle grounding", "0.750", "0.551–0.880", "+0.250", "6", "0", "0.031", "24"],
        ["oracle positions", "0.958", "0.798–0.993", "+0.208", "6", "1", "0.125", "24"],
        ["answer given", "1.000", "—", "+0.042", "1", "0", "1.000", "24"],
    ]


def test_metrics_without_rows_are_an_empty_table():
    for kind, make in (
        (TaxonomyCount, taxonomy_table),
        (Comparison, significance_table),
        (Navigation, navigation_table),
        (Difficulty, difficulty_table),
        (Step, budget_table),
    ):
        table = make(rows(kind, []), SETTINGS)
        assert len(table_csv(table).splitlines()) == 1 and markdown(table) and latex(table, "empty")


def test_p_values_keep_their_size():
    assert [p_value(value) for value in (1.0, 0.05049, 0.001, 4.42860e-41, 0.00099, 0.0)] == [
        "1.000", "0.050", "0.001", "4.4e-41", "9.9e-4", "0",
    ]  # fmt: skip
    assert [power_of_ten(text) for text in ("4.4e-41", "0.050")] == [r"$4.4\times10^{-41}$", "0.050"]
    assert (count(3.0), count(40.75, expected=True), signed(-0.0125)) == ("3", "40.8", "-0.013")
