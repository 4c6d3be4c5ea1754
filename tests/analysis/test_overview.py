"""Who reaches what: each rate is that of the split's own metrics, controls stand last, the README shows rates of the release."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pandas as pd
import pytest

from ovman.analysis import frames, overview
from ovman.analysis.controls import Judged
from ovman.analysis.overview import Overview
from ovman.analysis.rates import Rate, embodied_rates, static_rates
from ovman.analysis.statistics import wilson_interval
from ovman.report.tables.overview import overview_table
from ovman.report.tables.table import CONTROLS, SECTION
from ovman.settings import MAIN, Kind
from ovman.workflow.parameter import stage_settings
from tests.analysis.fabricated import embodied, static
from tests.arms import CONFIG
from tests.episodes import DATA

ROOT = Path(__file__).parents[2]
FILES = ("static", "embodied", "multi", "multi_embodied", "everyday", "everyday_embodied")


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    output = tmp_path_factory.mktemp("overview") / "overview.csv"
    rates, outcomes = ([DATA / "metrics" / f"{name}_{part}.csv" for name in FILES] for part in ("rates", "outcomes"))
    overview.run(rates, outcomes, stage_settings(CONFIG, "controls"), output)
    return frames.read(output, Overview)


def test_every_rate_is_the_splits_own(rows):
    met = 0
    for name in FILES:
        split = MAIN if name in set(Kind) else name.split("_")[0]
        kind = Kind.EMBODIED if name.endswith("embodied") else Kind.STATIC
        with (DATA / "metrics" / f"{name}_rates.csv").open(newline="") as file:
            own = {row["arm"]: float(row["rate"]) for row in csv.DictReader(file) if row["relation"] == "all"}
        for title, entry in CONFIG.comparisons.overview.items():
            arm = entry.static if kind is Kind.STATIC else entry.embodied
            shown = rows[(rows["title"] == title) & (rows["split"] == split) & (rows["kind"] == kind)]
            assert shown["rate"].tolist() == [own[name] for name in (arm,) if name in own], (title, name)
            met += len(shown)
    assert met == len(rows) > 40


def test_an_entry_has_the_rate_of_its_arm_of_each_kind_over_all_relations(tmp_path):
    title, entry = next((t, e) for t, e in CONFIG.comparisons.overview.items() if e.static and e.embodied)
    control = next(e.static for e in CONFIG.comparisons.overview.values() if e.static and CONFIG.arms[e.static].control)
    answers = [static(arm, n, n < 3) for arm in (entry.static, control) for n in range(4)]
    rates = {Kind.STATIC: static_rates(answers, 0.95)}
    rates[Kind.EMBODIED] = embodied_rates([embodied(entry.embodied, n, n < 2, spl=0.5) for n in range(4)], 0.95)
    judged = [Judged(MAIN, kind, tmp_path / f"{kind}_rates.csv", tmp_path / f"{kind}_outcomes.csv") for kind in Kind]
    for one in judged:
        frames.write(one.rates, Rate, rates[one.kind])
    found = overview.overview(judged, stage_settings(CONFIG, "controls"))
    low, high = (pytest.approx(bound, abs=1e-6) for bound in wilson_interval(3, 4))
    of_static = Overview(title, MAIN, Kind.STATIC, entry.static, False, 4, 0.75, low, high, None)
    low, high = (pytest.approx(bound, abs=1e-6) for bound in wilson_interval(2, 4))
    of_embodied = Overview(title, MAIN, Kind.EMBODIED, entry.embodied, False, 4, 0.5, low, high, 0.25)
    assert [row for row in found if row.title == title] == sorted(
        (of_static, of_embodied), key=lambda row: [*Kind].index(row.kind)
    )
    assert {row.control for row in found if row.arm == control} == {True}


def test_controls_stand_last_and_nothing_else_among_them(rows):
    made = overview_table(rows, CONFIG).rows
    control = [
        all(CONFIG.arms[arm].control for arm in (entry.static, entry.embodied) if arm is not None)
        for entry in (CONFIG.comparisons.overview[title] for title in made["system"])
    ]
    assert control == sorted(control) and any(control) and not all(control)
    assert [section == CONTROLS for section in made[SECTION]] == control


def test_the_readme_shows_rates_of_the_release(rows):
    """Each row of its table, by the title's beginning."""
    table = overview_table(rows, CONFIG).rows.set_index("system")
    lines = re.findall(r"^\| ([^|]+?) *\|((?: +[\d.—]+ \|){4})$", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert len(lines) == 6
    for title, cells in lines:
        row = table.loc[title.partition(", a control")[0]]
        columns = [f"{split}_{kind}" for split in ("main", "everyday") for kind in ("static", "embodied")]
        rates = ["—" if pd.isna(row[column]) else f"{row[column]:.3f}" for column in columns]
        assert cells.replace("|", " ").split() == rates, title
