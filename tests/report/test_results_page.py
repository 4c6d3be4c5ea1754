"""The page of results: the one in docs is that of the released metrics, and partial metrics give a page, too."""

from __future__ import annotations

import re
from pathlib import Path

from ovman.analysis.registry import compared
from ovman.report.figures import CHARTS
from ovman.report.metrics import Metrics, name_arms
from ovman.report.results_page import judge_all, render, write_page
from ovman.report.statements import STATEMENTS, Verdict
from tests.arms import CONFIG
from tests.episodes import DATA

DOCS = Path(__file__).parents[2] / "docs"
FILES = {path.stem: path for path in (DATA / "metrics" / f"{name}.csv" for name in compared(CONFIG))}
ARMS = name_arms(CONFIG.comparisons, CONFIG.paper)


def test_the_page_in_docs_is_that_of_the_released_metrics(tmp_path, capsys):
    write_page(list(FILES.values()), CONFIG, tmp_path / "page.md")
    page = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert page == (DOCS / "results.md").read_text(encoding="utf-8")
    assert len(capsys.readouterr().out.splitlines()) == len(STATEMENTS)
    assert {*re.findall(r"!\[[^]]*\]\(([^)]*)\)", page)} == {f"figures/{name}.png" for name in CHARTS}
    assert not re.search(r"\bnan\b|\binf\b|\bNone\b|Undefined|\{\{|\{%", page)


def test_without_a_file_the_page_says_so_once_per_statement():
    metrics = Metrics.load([path for name, path in FILES.items() if name != "controls"], ARMS)
    judgements = judge_all(metrics)
    page = render(metrics, judgements, CONFIG)
    without = [one for one in judgements.values() if one.verdict is Verdict.UNKNOWN]
    assert page.count("  - cannot be told: there is no controls.csv") == len(without)
    assert without or "Nothing can be told: there is no controls.csv." in page
    assert not re.search(r"\bnan\b|None", page)


def test_no_metrics_and_files_without_rows_are_a_page_too():
    empty = Metrics({name: Metrics.load([path], ARMS).frame(name).iloc[:0] for name, path in FILES.items()}, ARMS)
    for metrics in (Metrics({}, ARMS), empty):
        page = render(metrics, judge_all(metrics), CONFIG)
        assert page.count("?\u00a0cannot\u00a0be\u00a0told") == len(STATEMENTS)
        assert "0 hold here, 0 do not" in " ".join(page.split()) and "over — episodes" in page
