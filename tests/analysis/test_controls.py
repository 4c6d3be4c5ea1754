"""Controls beside agents and chance: rows of every split, their table and their figure, from outcomes that are made up."""

from __future__ import annotations

from dataclasses import asdict

import pytest

from ovman.analysis import controls, frames
from ovman.analysis.controls import Controlled, Judged
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import Rate, embodied_rates, static_rates
from ovman.records.task import Relation
from ovman.report.figures.rates import draw_controls
from ovman.report.metrics import Metrics, name_arms
from ovman.report.tables.controls import CHANCE, controls_table
from ovman.report.tables.table import SECTION, markdown
from ovman.settings import Kind
from ovman.workflow.parameter import stage_settings
from tests.analysis.fabricated import embodied, static
from tests.arms import CONFIG

CONSTANTS = stage_settings(CONFIG, "controls")
SHOWN = CONFIG.comparisons.controls
STRANGER = "maintained_map"
"""An arm that is in the rates and not in the table of controls."""
OF_KIND = {kind: [name for name in SHOWN if CONFIG.arms[name].kind is kind] for kind in Kind}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Rates and outcomes of the benchmark's own split, on paper and driving, and of another one with two relations."""
    directory = tmp_path_factory.mktemp("metrics")
    arms = [*reversed(OF_KIND[Kind.STATIC]), STRANGER]

    def outcomes(count):
        return [
            static(arm, n, (n + k) % 3 == 0, instances=2 + n % 3, alike=1 + n % 4)
            if not CONFIG.arms[arm].expected
            else static(arm, n, 0.25, "expected", instances=2 + n % 3, alike=1 + n % 4)
            for k, arm in enumerate(arms)
            for n in range(count)
        ]

    driven = [embodied(arm, n, n % 2 == 0, seed) for arm in OF_KIND[Kind.EMBODIED] for seed in (0, 1) for n in range(12)]
    made = {"static": outcomes(12), "multi": outcomes(2), "embodied": driven}
    for name, group in made.items():
        kind, rates = (EmbodiedOutcome, embodied_rates) if name == "embodied" else (StaticOutcome, static_rates)
        frames.write(directory / f"{name}_outcomes.csv", kind, group)
        frames.write(directory / f"{name}_rates.csv", Rate, rates(group, 0.95))
    output = directory / "controls.csv"
    paths = [[directory / f"{name}_{what}.csv" for name in ("static", "embodied", "multi")] for what in ("rates", "outcomes")]
    controls.run(*paths, CONSTANTS, output)
    return directory, output


def test_rates_are_those_of_the_split_in_the_order_of_the_settings(files):
    directory, output = files
    rows = frames.read_rows(output, Controlled)
    for split, kind, name in (
        ("main", Kind.STATIC, "static"),
        ("main", Kind.EMBODIED, "embodied"),
        ("multi", Kind.STATIC, "multi"),
    ):
        of = [row for row in rows if (row.split, row.kind) == (split, kind)]
        assert list(dict.fromkeys(row.arm for row in of)) == OF_KIND[kind]
        rates = {(rate.arm, rate.relation): rate for rate in frames.read_rows(directory / f"{name}_rates.csv", Rate)}
        for row in of:
            rate = rates[row.arm, row.relation]
            assert {key: value for key, value in asdict(row).items() if hasattr(rate, key)}.items() <= asdict(rate).items()
            assert row.control is CONFIG.arms[row.arm].control
    assert STRANGER not in {row.arm for row in rows}


def test_chances_are_means_of_one_over_the_instances_or_the_changes_alike_of_each_episode_once(files):
    _, output = files
    rows = frames.read_rows(output, Controlled)
    for row in rows:
        if row.split == "main" and row.kind is Kind.STATIC:
            numbers = [n for n in range(12) if row.relation in ("all", list(Relation)[n % 6])]
            assert row.chance == pytest.approx(sum(1 / (2 + n % 3) for n in numbers) / len(numbers)) and row.n == len(numbers)
            assert row.chance_of_change == pytest.approx(sum(1 / (1 + n % 4) for n in numbers) / len(numbers))


def test_a_row_is_the_rate_of_an_arm_beside_both_chances(files):
    directory, _ = files
    judged = Judged("main", Kind.EMBODIED, directory / "embodied_rates.csv", directory / "embodied_outcomes.csv")
    for row in controls.controlled(judged, CONSTANTS):
        assert (row.chance, row.chance_of_change) == (0.5, 1.0)


def test_every_file_of_rates_has_its_outcomes(tmp_path):
    with pytest.raises(ValueError, match="zip"):
        controls.judged_splits([tmp_path / "static_rates.csv"], [])


def test_what_contradicts_itself_is_one_line(files, tmp_path):
    directory, _ = files
    one = Judged("main", Kind.STATIC, directory / "static_rates.csv", directory / "multi_outcomes.csv")
    with pytest.raises(ValueError, match="is not in .*multi_outcomes.csv; make the metrics again$"):
        controls.controlled(one, CONSTANTS)


def test_the_table_has_a_block_a_split_with_agents_first_and_chance_last(files):
    _, output = files
    table = controls_table(frames.read(output, Controlled), CONFIG)
    blocks = [block for _, block in table.rows.groupby(SECTION, sort=False)]
    assert [(block["split"].iloc[0], block["judged"].iloc[0]) for block in blocks] == [
        ("main", "static gate"), ("main", "driving"), ("multi", "static gate")
    ]  # fmt: skip
    for block in blocks:
        what = block["what"].tolist()
        agents = what.count("agent")
        assert agents >= 2 and what == ["agent"] * agents + ["control"] * (len(what) - agents - 2) + ["chance"] * 2
        assert block["system"].iloc[-2:].tolist() == [*CHANCE.values()]
    page = markdown(table)
    assert "| multi " in page and "depth difference" in page and "nan" not in page
    assert len(controls_table(frames.frame_of(Controlled, []), CONFIG).rows) == 0


def test_the_figure_is_drawn_the_same_twice_and_of_nothing(files, tmp_path):
    _, output = files
    rows = name_arms(CONFIG.comparisons, CONFIG.paper)
    for name, paths in (("one", [output]), ("other", [output]), ("nothing", [])):
        draw_controls(Metrics.load(paths, rows), CONFIG, tmp_path / f"{name}.png")
    one, other, nothing = ((tmp_path / f"{name}.png").read_bytes() for name in ("one", "other", "nothing"))
    assert one == other != nothing
