"""The pages of results: those in docs are of the released metrics, and partial metrics give pages, too."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ovman.analysis.registry import compared
from ovman.report.figures import CHARTS
from ovman.report.metrics import Metrics, name_arms
from ovman.report.results_page import PAGES, judge_all, read_choices, render, tabulate_choices, write_pages
from ovman.report.statements import STATEMENTS, Verdict
from tests.arms import CONFIG
from tests.episodes import DATA, ROOT

DOCS = Path(__file__).parents[2] / "docs"
FILES = [DATA / "metrics" / f"{name}.csv" for name in compared(CONFIG)]
ARMS = name_arms(CONFIG.comparisons, CONFIG.paper)
BROKEN = re.compile(r"\bnan\b|\binf\b|\bNone\b|Undefined|\{\{|\{%")


@pytest.fixture(scope="module")
def metrics() -> Metrics:
    return Metrics.load(FILES, ARMS)


def test_the_pages_in_docs_are_those_of_the_released_metrics(tmp_path, capsys):
    write_pages(FILES, CONFIG, tmp_path)
    assert len(capsys.readouterr().out.splitlines()) == len(STATEMENTS)
    pages = {name: (tmp_path / f"{name}.md").read_text(encoding="utf-8") for name in PAGES}
    for name, page in pages.items():
        assert page == (DOCS / f"{name}.md").read_text(encoding="utf-8"), name
        assert not BROKEN.search(page), name
    every = "".join(pages.values())
    assert {*re.findall(r"!\[[^]]*\]\(([^)]*)\)", every)} == {f"figures/{name}.png" for name in CHARTS}
    assert len(pages["results"].split()) <= 2500
    assert all(statement.key in every for statement in STATEMENTS)


def test_the_choices_are_the_same_wherever_they_are_shown():
    shown = tabulate_choices(CONFIG)
    assert shown in (DOCS / "results.md").read_text(encoding="utf-8")
    assert shown.rstrip() in (ROOT / "dataset" / "README.md").read_text(encoding="utf-8")
    for entry in read_choices():
        assert {*entry} - {"settings"} == {"choice", "paper", "ours", "effect"} and all(entry.values()), entry


def test_without_a_file_the_page_says_so_once_per_statement():
    some = Metrics.load([path for path in FILES if path.stem != "significance"], ARMS)
    judgements = judge_all(some)
    pages = render(some, judgements, CONFIG)
    without = [one for one in judgements.values() if one.verdict is Verdict.UNKNOWN]
    assert without and pages["verdicts"].count("  - cannot be told: there is no significance.csv") == len(without)
    assert not any(map(BROKEN.search, pages.values()))


def test_no_metrics_and_files_without_rows_are_a_page_too(metrics):
    names = [f"{path.parent.name}/{path.stem}" if path.stem.endswith("_outcomes") else path.stem for path in FILES]
    empty = Metrics({name: metrics.frame(name).iloc[:0] for name in names}, ARMS)
    for some in (Metrics({}, ARMS), empty):
        pages = render(some, judge_all(some), CONFIG)
        shown = pages["verdicts"] + pages["beyond"]
        assert shown.count("?\u00a0cannot\u00a0be\u00a0told") == len(STATEMENTS)
        assert "0 hold here, 0 do not" in " ".join(pages["results"].split()) and "cover — episodes" in pages["results"]
