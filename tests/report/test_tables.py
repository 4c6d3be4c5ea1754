from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from ovman.analysis import frames
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import Rate, embodied_rates, static_rates
from ovman.analysis.registry import METRICS, compared, in_tables
from ovman.report.tables import stages
from ovman.report.tables.constants import KEYS, constants_table, value_text
from ovman.report.tables.rejections import RejectionCount, rejections_table
from ovman.report.tables.specs import SPECS
from ovman.report.tables.table import csv_text as table_csv
from ovman.settings import Need, arms_of
from ovman.settings.config import load
from ovman.settings.settings_files import read_merged, with_parts
from ovman.task import Relation
from tests.report.reading import settings

REJECTIONS_MD = """\
Audit of the candidates: first reason of rejection by relation, in the order of the checks.

| stage         | reason               |   MOVED |   FORMER |   MOVING |   STABLE |   APPEARED |   REMOVED |   ALL |
|:--------------|:---------------------|--------:|---------:|---------:|---------:|-----------:|----------:|------:|
| drawn         | —                    |       9 |        9 |        9 |        9 |          9 |         9 |    54 |
| placement     | placement_refused    |       3 |        2 |        2 |        2 |          2 |         2 |    13 |
| certification | certification_failed |       0 |        1 |        1 |        1 |          1 |         1 |     5 |
| certified     | —                    |       6 |        6 |        6 |        6 |          6 |         6 |    36 |
| released      | —                    |       5 |        6 |        6 |        6 |          6 |         6 |    35 |
"""
CONFIG = Path(__file__).parents[2] / "config.yaml"


def namespace(value):
    return SimpleNamespace(**{key: namespace(member) for key, member in value.items()}) if isinstance(value, dict) else value


@pytest.fixture
def constants():
    read = namespace(read_merged(with_parts(CONFIG)))
    loaded = load(CONFIG)
    read.arms, read.comparisons, read.splits = loaded.arms, loaded.comparisons, loaded.splits
    return read


def static(arm, successes, outcome="answered", per_relation=4):
    """Outcomes of one arm: in each relation the given number of successes, or that share of each episode if it is expected."""
    rows = []
    for relation in Relation:
        for number in range(per_relation):
            success = successes / per_relation if outcome == "expected" else float(number < successes)
            episode = f"FloorPlan1/{relation}/{number:04d}"
            rows.append(StaticOutcome(episode, "FloorPlan1", relation, "Chair", 2, 1, arm, 0, outcome, None, None, success))
    return rows


def embodied(arm, seeds=3, per_relation=2):
    return [
        EmbodiedOutcome(f"FloorPlan1/{relation}/{number:04d}", "FloorPlan1", relation, "Chair", 2, 1, arm, seed, "stopped",
                        (number, seed) != (0, 1), 0.9 * ((number, seed) != (0, 1)), 3.0, 20)
        for seed in range(seeds) for relation in Relation for number in range(per_relation)
    ]  # fmt: skip


REJECTIONS = "relation,stage,reason,count\n" + "".join(
    f"{relation},drawn,,9\n{relation},placement,placement_refused,{3 if relation == 'moved' else 2}\n"
    f"{relation},certification,certification_failed,{0 if relation == 'moved' else 1}\n"
    f"{relation},certified,,6\n{relation},released,,{5 if relation == 'moved' else 6}\n"
    for relation in (relation.value for relation in Relation)
)


@pytest.fixture
def metrics(tmp_path):
    def write(name, rates):
        frames.write(tmp_path / name, Rate, rates)

    outcomes = static("positions_single_visit", 1, "expected") + static("positions_two_visits", 4)
    write("static_rates.csv", static_rates(outcomes, 0.95))
    write("embodied_rates.csv", embodied_rates(embodied("oracle_check"), 0.95))
    (tmp_path / "rejections.csv").write_text(REJECTIONS)
    return tmp_path / "static_rates.csv", tmp_path / "embodied_rates.csv", tmp_path / "rejections.csv"


def read(path):
    return list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))


def test_every_table_in_every_format_and_twice_the_same(metrics, constants, tmp_path):
    for where in ("one", "other"):
        stages.run(metrics, constants, tmp_path / where)
    names = {
        f"{table}.{suffix}"
        for table in ("position", "constants", "static", "embodied", "rejections")
        for suffix in ("csv", "md", "tex")
    }
    assert {path.name for path in (tmp_path / "one").iterdir()} == names
    assert all((tmp_path / "one" / name).read_bytes() == (tmp_path / "other" / name).read_bytes() for name in names)


def test_the_static_table_on_a_page(metrics, constants, tmp_path):
    stages.run(metrics, constants, tmp_path / "tables")
    page = (tmp_path / "tables" / "static.md").read_text(encoding="utf-8")
    caption, table = page.split("\n\n")
    assert " ".join(caption.split()).startswith(
        "Static gate: a prediction succeeds within 1.0 m of the answer. Ranges are Wilson 95 % intervals. † A stochastic pick:"
    )
    header, rule, *rows = table.splitlines()
    assert len({len(line) for line in (header, rule, *rows)}) == 1
    assert [[cell.strip() for cell in line.strip("|").split("|")] for line in (header, *rows)] == [
        ["system", "memory", "grounding", "positions", *(relation.upper() for relation in Relation), "ALL", "95 %", "n", "runs"],
        ["reference agent", "single visit", "oracle", "oracle", *["0.250"] * 7, "0.083–0.417†", "24", "1"],
        ["reference agent", "two visits", "oracle", "oracle", *["1.000"] * 7, "0.862–1.000", "24", "1"],
    ]
    tex = (tmp_path / "tables" / "static.tex").read_text(encoding="utf-8")
    assert r"\multicolumn{12}{l}{\emph{oracle positions (diagnostic)}} \\" in tex
    assert r"\begin{table*}" in tex and r"$^\dagger$" in tex
    assert tex.isascii()


def test_the_static_csv_has_an_interval_beside_every_rate(metrics, constants, tmp_path):
    stages.run(metrics, constants, tmp_path / "tables")
    single, two = read(tmp_path / "tables" / "static.csv")
    design = ["system", "memory", "grounding", "positions", *(relation.value for relation in Relation), "all", "n", "runs"]
    assert [key for key in single if not key.endswith(("_low", "_high", "_min", "_max")) and key != "interval"] == design
    for row in (single, two):
        for key in (*(relation.value for relation in Relation), "all"):
            assert float(row[f"{key}_low"]) <= float(row[key]) <= float(row[f"{key}_high"])
    assert (single["memory"], single["all"], single["interval"]) == ("single visit", "0.250", "poisson_binomial")
    assert (two["memory"], two["all"], two["all_low"], two["all_high"]) == ("two visits", "1.000", "0.862", "1.000")
    assert two["n"] == "24"


def test_the_embodied_csv(metrics, constants, tmp_path):
    stages.run(metrics, constants, tmp_path / "tables")
    (row,) = read(tmp_path / "tables" / "embodied.csv")
    assert [row[key] for key in ("agent", "sr", "spl", "n", "seeds")] == ["oracle check", "0.833", "0.750", "12", "3"]
    assert float(row["sr_low"]) < 0.833 < float(row["sr_high"])


def test_arms_that_do_not_exist_have_no_row(metrics, constants, tmp_path):
    lines = metrics[0].read_text().splitlines(keepends=True)
    metrics[0].write_text("".join(line for line in lines if not line.startswith("positions_single_visit")))
    stages.run(metrics, constants, tmp_path / "tables")
    assert [row["memory"] for row in read(tmp_path / "tables" / "static.csv")] == ["two visits"]
    assert "†" not in (tmp_path / "tables" / "static.md").read_text(encoding="utf-8")


def test_a_relation_without_episodes_is_empty_not_zero(metrics, constants, tmp_path):
    lines = metrics[0].read_text().splitlines(keepends=True)
    metrics[0].write_text("".join(line for line in lines if ",stable," not in line))
    stages.run(metrics, constants, tmp_path / "tables")
    assert all(row["stable"] == row["stable_low"] == "" for row in read(tmp_path / "tables" / "static.csv"))
    assert " — |" in (tmp_path / "tables" / "static.md").read_text(encoding="utf-8")


def test_an_arm_in_the_wrong_table_is_refused(metrics, constants, tmp_path):
    metrics[1].write_text(metrics[1].read_text().replace("oracle_check", "positions_two_visits"))
    with pytest.raises(ValueError, match="embodied_rates.csv: 'positions_two_visits' is not an arm of this table"):
        stages.run(metrics, constants, tmp_path / "tables")


def test_the_audit_adds_up(metrics, constants, tmp_path):
    stages.run(metrics, constants, tmp_path / "tables")
    assert (tmp_path / "tables" / "rejections.md").read_text(encoding="utf-8") == REJECTIONS_MD
    rows = read(tmp_path / "tables" / "rejections.csv")
    drawn, *rejected, certified, released = rows
    for key in (*(relation.value for relation in Relation), "all"):
        assert int(drawn[key]) == sum(int(row[key]) for row in rejected) + int(certified[key])


@pytest.mark.parametrize(
    "change, message",
    [
        (("moved,drawn,,9", "moved,drawn,,10"), "moved has 10 drawn, but 3 rejected and 6 certified"),
        (("moved,released,,5", "moved,released,,7"), "7 released of 6 certified"),
        (("placement,placement_refused", "placement,tired"), "placement tired"),
        (("former,drawn,,9", "moved,drawn,,9"), "counted twice"),
        (("former,drawn,,9", "vanished,drawn,,9"), "not a change relation"),
    ],
)
def test_an_audit_that_contradicts_itself_is_not_printed(change, message):
    with pytest.raises(ValueError, match=message):
        rejections_table(
            frames.typed(pd.read_csv(io.StringIO(REJECTIONS.replace(*change)), dtype=str, keep_default_na=False), RejectionCount),
            settings(),
        )


def test_constants_are_those_in_force(constants):
    before = {row["setting"]: row for row in csv.DictReader(io.StringIO(table_csv(constants_table(constants))))}
    assert list(before) == list(KEYS)
    assert before["success.radius_m"]["symbol"] == "R"
    for key in KEYS:
        *sections, name = key.split(".")
        section = reduce(getattr, sections, constants)
        value = getattr(section, name)
        changed = [*value, 75] if isinstance(value, list) else value + 3
        setattr(section, name, changed)
        after = {row["setting"]: row for row in csv.DictReader(io.StringIO(table_csv(constants_table(constants))))}
        assert {other for other in KEYS if after[other] != before[other]} == {key}
        setattr(section, name, value)


def test_values_of_the_paper(constants):
    values = {row["setting"]: (row["value"], row["unit"]) for _, row in constants_table(constants).rows.iterrows()}
    assert values["success.radius_m"] == ("1.0", "m")
    assert values["association.gate_m"] == ("1.25", "m")
    assert values["success.sweep_deg"] == ("0, 30, 60", "°")
    assert values["primitives.turn_deg"] == ("30", "°")
    assert values["primitives.action_budget"] == ("500", "actions")


def test_a_whole_number_of_metres_is_the_same_however_it_is_written():
    assert value_text(2, "m") == value_text(2.0, "m") == "2.0"
    assert value_text(30, "°") == value_text(30.0, "°") == "30"


def test_every_shown_constant_is_a_setting(constants):
    assert len(set(KEYS)) == len(KEYS)
    for key in KEYS:
        assert reduce(getattr, key.split("."), constants) is not None


def test_every_metric_with_a_table_has_a_spec_and_no_other():
    assert list(SPECS) == [metric.name for metric in METRICS if metric.table is not None]
    assert len({metric.name for metric in METRICS}) == len(METRICS)
    assert len({metric.table for metric in METRICS if metric.table}) == len(SPECS)


def test_metrics_of_dualmap_are_shown_only_where_an_arm_needs_its_maps():
    arms = arms_of(load(CONFIG).arms)
    without = [arm for arm in arms if Need.DUALMAP not in arm.needs]
    assert set(in_tables(arms)) - set(in_tables(without)) == {"dualmap"} == set(compared(arms)) - set(compared(without))


def test_a_file_that_no_table_shows_is_refused(metrics, constants, tmp_path):
    other = metrics[0].rename(tmp_path / "static_outcomes.csv")
    with pytest.raises(ValueError, match="no table shows static_outcomes; those that are shown are static_rates,"):
        stages.run([other], constants, tmp_path / "tables")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("successes", "wins"), "static_rates.csv: no column successes, there are arm, relation,"),
        (("0.250000", "many"), "static_rates.csv: rate is 'many', which is no finite number"),
        (("0.250000", "nan"), "static_rates.csv: rate is 'nan', which is no finite number"),
    ],
)
def test_a_file_with_other_columns_or_no_numbers_is_one_line(metrics, constants, tmp_path, change, message):
    metrics[0].write_text(metrics[0].read_text().replace(*change))
    with pytest.raises(ValueError, match=message) as caught:
        stages.run(metrics, constants, tmp_path / "tables")
    assert "\n" not in str(caught.value)


@dataclass(frozen=True)
class Row:
    """A row with every kind of column."""

    name: str | None
    share: float
    p: float | None
    count: int
    some: int | None
    known: bool | None


def test_rows_come_back_from_a_file_as_they_were(tmp_path):
    made = [Row("a", 0.25, 1.5e-23, 3, None, True), Row(None, -0.0, None, 0, 7, None), Row("b,c", 1.0, 0.5, 1, 1, False)]
    frames.write(tmp_path / "rows.csv", Row, made)
    assert (tmp_path / "rows.csv").read_text().splitlines() == [
        "name,share,p,count,some,known", "a,0.250000,1.5e-23,3,,1", ",0.000000,,0,7,", '"b,c",1.000000,0.5,1,1,0',
    ]  # fmt: skip
    assert frames.read_rows(tmp_path / "rows.csv", Row) == made
