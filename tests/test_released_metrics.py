"""Metrics and tables follow from the released episodes, predictions and runs: every value comes out as it was released.

`make golden` compares all splits and tables; this file runs with every `make test` and covers the split main.
"""

from __future__ import annotations

import pytest

from ovman.analysis.metrics import write_metrics
from ovman.analysis.rates import Rate
from ovman.analysis.registry import SPLIT_METRICS, STATIC_TABLES
from ovman.analysis.rows import read_rows
from ovman.report.tables import write_tables
from tests.arms import CONFIG
from tests.episodes import DATA


@pytest.fixture(scope="module")
def rebuilt(tmp_path_factory):
    """The metrics of main, made of the released records."""
    directory = tmp_path_factory.mktemp("metrics") / "main"
    write_metrics(
        DATA / "episodes" / "main.jsonl",
        sorted((DATA / "predictions" / "main").glob("*.jsonl")),
        sorted((DATA / "scores" / "main").glob("*.jsonl")),
        CONFIG,
        directory,
    )
    return directory


@pytest.mark.parametrize("name", SPLIT_METRICS)
def test_metrics_follow_from_the_released_records(rebuilt, name):
    assert (rebuilt / f"{name}.csv").read_bytes() == (DATA / "metrics" / "main" / f"{name}.csv").read_bytes()


def test_tables_follow_from_the_metrics(rebuilt, tmp_path):
    names = [name for name in SPLIT_METRICS if not name.endswith("outcomes")]
    assert {*STATIC_TABLES} < {*names}
    write_tables([rebuilt / f"{name}.csv" for name in names], CONFIG, tmp_path)
    made = sorted(tmp_path.iterdir())
    assert len(made) == 3 * len(names)
    for path in made:
        assert path.read_bytes() == (DATA / "tables" / path.name).read_bytes(), path.name


def test_oracles_reach_the_ceiling():
    rates = {(row.arm, row.relation): row.rate for row in read_rows(DATA / "metrics" / "main" / "static_rates.csv", Rate)}
    assert rates["positions_two_visits", "all"] >= 0.97
    rates = {(row.arm, row.relation): row.rate for row in read_rows(DATA / "metrics" / "main" / "embodied_rates.csv", Rate)}
    assert rates["oracle_check", "all"] >= 0.98 and rates["two_visits_oracle_positions", "all"] >= 0.97
