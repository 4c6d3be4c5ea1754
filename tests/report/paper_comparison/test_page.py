from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from ovman.report.paper_comparison import page
from ovman.report.paper_comparison import statement as statements
from ovman.report.paper_comparison.explanations import Explanation, beside, read
from ovman.report.paper_comparison.metrics import Metrics
from ovman.report.paper_comparison.page import Sources, rendered
from ovman.report.paper_comparison.paper import Paper
from ovman.report.paper_comparison.statement import Verdict, every, judged
from ovman.workflow.parameter import stage_settings
from tests.arms import CONFIG
from tests.episodes import DATA as RELEASED
from tests.report.paper_comparison.papers import ARMS_BY_ROW, Files, metrics_of, papers_files, written_files

ROOT = Path(__file__).parents[3]
DOCS = ROOT / "docs"
PAPER = Paper.read()
STATEMENTS, OWN = every(statements.read()), every(statements.read(page.OWN))
PNG = b"\x89PNG\r\n\x1a\n"


def constants(backend: str = "embedded", weights: str = "models/one.safetensors") -> SimpleNamespace:
    return SimpleNamespace(
        benchmark=SimpleNamespace(backend=backend),
        perception=SimpleNamespace(
            detector=SimpleNamespace(architecture="yolov8n-seg", weights=weights),
            encoder=SimpleNamespace(model="models/encoder.json", weights=weights),
        ),
        evaluation=SimpleNamespace(confidence=0.95),
        arms=CONFIG.arms,
        comparisons=CONFIG.comparisons,
        paper=CONFIG.paper,
    )


def of(files: Files, explanations: dict[str, Explanation] | None = None, **kwargs: str) -> str:
    return rendered(metrics_of(files), Sources(), constants(**kwargs), explanations or {})


def tables(text: str) -> list[list[str]]:
    """Every run of lines that begin with a bar."""
    return [run.splitlines() for run in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)]


def without(files: Files, name: str) -> Files:
    return {file: rows for file, rows in files.items() if file != name}


def in_scene(files: Files, rate: str) -> Files:
    """The files with another success of every static arm in all its rows."""
    return files | {"static_rates.csv": [row | {"rate": rate} for row in files["static_rates.csv"]]}


@pytest.fixture(scope="module")
def whole() -> str:
    return of(papers_files())


def test_a_page_of_the_papers_own_figures(whole):
    total = len(STATEMENTS)
    said = "0 do not, 0 hold under some readings of a definition only, 0 cannot be told**"
    assert f"**Of {total} statements of the paper {total} hold here, {said}" in " ".join(whole.split())
    assert re.search(r"^\| reference agent, two visits, static +\| +\*\*0.416\*\* \| +0.416 \|$", whole, re.MULTILINE)
    assert whole.count("✓\u00a0holds") == total + len(OWN) and "✗" not in whole and "?\u00a0" not in whole
    assert "[!WARNING]" not in whole and whole.endswith("\n") and not whole.endswith("\n\n")
    assert not re.search(r"\bnan\b|\binf\b|\bNone\b|Undefined|\{\{|\{%", whole)
    assert max(map(len, re.findall(r"\n{2,}", whole))) == 2, "no two empty lines in a row"


def test_tables_are_tables(whole):
    found = tables(whole)
    assert len(found) >= 10
    for table in found:
        assert len({line.replace(r"\|", "").count("|") for line in table}) == 1, table[0]
        assert set(table[1]) <= set("|-: ")


def test_ours_and_the_papers_stand_below_each_other(whole):
    pairs = [
        (here.split("|")[3:], paper.split("|")[3:])
        for table in tables(whole)
        for here, paper in zip(table, table[1:], strict=False)
        if "| here " in here and "| paper |" in paper
    ]
    assert len(pairs) == 10 + 5 + 7
    assert all(here == paper for here, paper in pairs)


def test_the_same_metrics_give_the_same_page_and_others_another(whole):
    assert of(papers_files()) == whole
    assert of(in_scene(papers_files(), "0.123")) != whole


def test_what_fails_is_named_at_the_top_and_marked_below():
    text = of(in_scene(papers_files(), "0.2"))
    top, below = text.split("## How to read it")
    metrics = metrics_of(in_scene(papers_files(), "0.2"))
    failing, own = ([s for s in some if judged(s, metrics).verdict is Verdict.FAILS] for some in (STATEMENTS, OWN))
    assert failing and all(statement.claim in top for statement in failing)
    assert (
        below.count("✗\u00a0does\u00a0not\u00a0hold")
        == len(failing) + len(own)
        == below.count("No explanation yet: the frames have not been inspected.")
    )


@pytest.mark.parametrize(
    "name", [name if k % 6 == 0 else pytest.param(name, marks=pytest.mark.soak) for k, name in enumerate(sorted(papers_files()))]
)
def test_without_a_file_the_page_says_so_once_a_statement(name):
    text = of(without(papers_files(), name))
    metrics = metrics_of(without(papers_files(), name))
    reading = [one for one in (*STATEMENTS, *OWN) if name.removesuffix(".csv") in one.model_dump_json()]
    untold = [statement for statement in reading if judged(statement, metrics).verdict is Verdict.UNKNOWN]
    assert untold and text.count(f"  - cannot be told: there is no {name}") == len(untold)
    assert not re.search(r"\bnan\b|None", text)


def test_no_metrics_at_all_is_a_page_too():
    text = of({})
    assert text.count("?\u00a0cannot\u00a0be\u00a0told") == len(STATEMENTS) + len(OWN)
    assert "0 hold here, 0 do not" in " ".join(text.split()) and "over — episodes" in text


def test_files_without_rows_are_a_page_too():
    empty = of({name: [] for name in (*papers_files(), "perception.csv")})
    assert empty.count("?\u00a0cannot\u00a0be\u00a0told") == len(STATEMENTS) + len(OWN)
    assert "Nothing can be told: perception.csv has no rows." in empty


def test_a_small_run_is_called_one():
    files = papers_files()
    text = of(files | {"static_rates.csv": [row | {"n": "14"} for row in files["static_rates.csv"]]})
    assert "These metrics are over 14 episodes, not over the 219 of the release" in text


def test_it_says_whose_pictures_and_weights_these_are():
    assert "this project's own engine" in of({}) and "trained here" in of({})
    other = of({}, backend="thor", weights="laion2b_s34b_b88k")
    assert "Unity build as well" in other and "trained here" not in other and "`laion2b_s34b_b88k`" in other


def explained(verdict: Verdict) -> dict[str, Explanation]:
    return {"two_beat_one": Explanation(verdict=verdict, text="The chair is\nhidden.", episodes=("FloorPlan1/moved/0000",))}


def test_an_explanation_is_shown_beside_the_verdict_that_it_belongs_to():
    failing = in_scene(papers_files(), "0.2")
    text = of(failing, explained(Verdict.FAILS))
    assert "**1.** The chair is hidden. (Looked at: `FloorPlan1/moved/0000`.) *Written by hand.*" in text


def test_an_explanation_of_another_verdict_is_flagged_and_left_out(whole):
    text = of(papers_files(), explained(Verdict.FAILS))
    assert "The chair is" not in text
    assert "**1.** ⚠ The explanation at hand was written when the verdict was “does not hold”. Now it is “holds”" in text
    assert "⚠" not in whole


def test_every_pair_of_verdicts_is_either_shown_or_flagged():
    statement = STATEMENTS[0]
    judgements = {
        judgement.verdict: judgement
        for files in (papers_files(), in_scene(papers_files(), "0.2"), {})
        for judgement in [judged(statement, metrics_of(files))]
    }
    assert set(judgements) == set(Verdict) - {Verdict.SOME}
    for there in judgements:
        for written in judgements:
            note = beside(judgements[there], explained(written), metrics_of({}), PAPER, {})
            assert note is not None and ("hidden" in note) == (there is written) == ("⚠" not in note)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("two_beat_nobody: {verdict: holds, text: a}", "two_beat_nobody is the key of no statement"),
        ("two_beat_one: {verdict: perhaps, text: a}", "two_beat_one.verdict"),
        ("two_beat_one: {verdict: holds, text: ''}", "two_beat_one.text"),
        ("two_beat_one: {verdict: holds, text: a, by: me}", "two_beat_one.by"),
        ("a: [", "explanations.yaml"),
    ],
)
def test_a_wrong_explanation_is_one_line(tmp_path, text, named):
    path = tmp_path / "explanations.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=re.escape(named)) as caught:
        read(STATEMENTS, path)
    assert "\n" not in str(caught.value) and str(path) in str(caught.value)


def test_the_explanations_at_hand_are_valid():
    assert all(explanation.text for explanation in read([*STATEMENTS, *OWN]).values())


def test_the_stage_writes_the_page_twice_the_same(tmp_path):
    files = written_files(tmp_path, papers_files())
    for turn in ("one", "other"):
        page.run(files, Sources(), constants(), page=tmp_path / turn)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()
    linked = re.findall(r"!\[[^]]*\]\(([^)]*)\)", (tmp_path / "one").read_text())
    assert sorted(linked) == [
        f"figures/{name}.png" for name in ("agent", "budget", "controls", "coverage", "difficulty", "memory", "sensitivity")
    ]


@pytest.mark.skipif(not (DOCS / "results.md").exists(), reason="no page has been released")
def test_the_page_in_docs_is_that_of_the_released_metrics():
    released = Metrics.load(sorted((RELEASED / "metrics").glob("*.csv")), ARMS_BY_ROW)
    owned = stage_settings(CONFIG, "paper_comparison")
    assert (DOCS / "results.md").read_text(encoding="utf-8") == rendered(released, Sources(), owned)
    assert all((DOCS / page.FIGURES / name).read_bytes().startswith(PNG) for name in ("budget.png", "memory.png"))
