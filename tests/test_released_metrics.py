"""Metrics and tables follow from the released episodes, predictions and runs: every value comes out as it was released."""

from __future__ import annotations

import re

import pytest

from ovman.analysis import metrics
from ovman.analysis.frames import read_rows
from ovman.analysis.rates import Rate
from ovman.analysis.registry import in_all_tables, in_tables, of_stage
from ovman.report.tables import stages
from ovman.workflow.parameter import stage_settings
from tests.arms import ARMS, CONFIG
from tests.episodes import DATA


def test_metrics_follow_from_the_released_records(rebuilt):
    assert (
        {path.stem for path in rebuilt.iterdir()}
        == {*of_stage("metrics")}
        <= {path.stem for path in (DATA / "metrics").iterdir()}
    )
    for path in rebuilt.iterdir():
        assert path.read_bytes() == (DATA / "metrics" / path.name).read_bytes(), path.name


def test_tables_follow_from_the_metrics(rebuilt, tmp_path):
    """Every cell and caption; what separates them is pandas' affair. The constants and prior work are no metrics."""
    plain, others = (
        [s for s in CONFIG.splits.values() if s.name != "main" and s.in_main_job and s.plain is plain] for plain in (True, False)
    )
    folders = DATA / "metrics", DATA / "metrics" / "paper", rebuilt
    of_all, of_paper = ({path.stem: path for folder in some for path in folder.glob("*.csv")} for some in (folders[::2], folders))
    shown = [*in_tables(ARMS, plain), *(path.stem for path in folders[1].iterdir())]
    stages.run([of_paper[name] for name in shown], stage_settings(CONFIG, "tables"), tmp_path / "tables")
    added = in_all_tables(ARMS, others)
    stages.run_split([of_all[name] for name in added], stage_settings(CONFIG, "split_tables"), tmp_path / "all")
    for folder, files in (("tables", 3 * (len(shown) + 2)), ("all", 3 * len(added))):
        made = {path.name for path in (tmp_path / folder).iterdir()}
        assert made == {path.name for path in (DATA / folder).iterdir()} and len(made) == files
        for name in sorted(made):
            ours, theirs = ((directory / folder / name).read_text(encoding="utf-8") for directory in (tmp_path, DATA))
            assert cells(name, ours) == cells(name, theirs), name


def cells(name: str, text: str) -> list[str]:
    """The lines of a table without what aligns and floats it; of the constants without the places of the settings."""
    if name == "constants.csv":
        return [line.rpartition(",")[0] for line in text.splitlines()]
    if name.endswith(".md"):
        lines = (re.sub(r" *\| *", "|", line) for line in text.partition("\n\n")[2].splitlines())
        return [line for line in lines if not re.fullmatch(r"[-:|]+", line)]
    return text.partition("\\begin{tabular}")[2].splitlines() if name.endswith(".tex") else text.splitlines()


@pytest.fixture(scope="module")
def rebuilt(tmp_path_factory):
    """The directory of metrics made of the released episodes, predictions and runs."""
    answered = {path.stem for path in (DATA / "predictions").iterdir()} | {path.name for path in (DATA / "runs").iterdir()}
    directory = tmp_path_factory.mktemp("metrics")
    metrics.run(
        DATA / "episodes" / "main.jsonl",
        sorted((DATA / "predictions").glob("*.jsonl")),
        sorted((DATA / "runs").glob("*/seed*/*.jsonl")),
        stage_settings(CONFIG, "metrics"),
        directory,
        [arm for arm in ARMS if arm.name in answered],
    )
    return directory


def test_what_must_come_out_does():
    rates = {(row.arm, row.relation): row.rate for row in read_rows(DATA / "metrics" / "static_rates.csv", Rate)}
    assert rates["positions_two_visits", "all"] >= 0.97
    rates = {(row.arm, row.relation): row.rate for row in read_rows(DATA / "metrics" / "embodied_rates.csv", Rate)}
    assert rates["oracle_check", "all"] >= 0.98 and rates["two_visits_oracle_positions", "all"] >= 0.97
