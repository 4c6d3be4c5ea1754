"""Pages of released episodes: sound HTML, the verdicts of the metrics, truth in its own layer."""

from __future__ import annotations

import csv
import json
import shutil

import numpy as np
import pytest

from ovman import cli
from ovman.perception.clusters import Cluster
from ovman.report.show.answers import shown_titles
from ovman.report.show.evidence import read_evidence
from ovman.report.show.page import render_page
from ovman.report.show.results import Results, ShowError
from ovman.settings import Kind
from tests.arms import BY_NAME, CONFIG
from tests.episodes import DATA
from tests.report.show.html_reader import Page

RELEASED = Results(DATA, CONFIG)
DRAWN = frozenset({"circle", "rect", "path", "polyline", "text", "use"})


@pytest.fixture(scope="module")
def pages() -> dict[str, tuple[str, Page]]:
    """Text and elements of the pages of an episode of each relation in split main, and of one of each split; by either."""
    episodes = RELEASED.episodes.values()
    chosen = {e.relation.value: e for e in episodes if e.split == "main"} | {e.split: e for e in episodes if e.split != "main"}
    texts = {name: render_page(RELEASED, episode) for name, episode in chosen.items()}
    return {name: (chosen[name], text, Page(text)) for name, text in texts.items()}


@pytest.fixture
def few(tmp_path):
    """A release with the first episode of split main alone, to be changed, and the episode's record."""
    root = tmp_path / "results"
    for stage in ("episodes", "predictions", "scenes"):
        (root / stage).mkdir(parents=True)
    record = json.loads((DATA / "episodes" / "main.jsonl").read_text().splitlines()[0])
    (root / "episodes" / "main.jsonl").write_text(json.dumps(record) + "\n")
    shutil.copytree(DATA / "predictions" / "main", root / "predictions" / "main")
    shutil.copy(DATA / "scenes" / "main.jsonl", root / "scenes")
    return root, record


def test_a_page_is_one_sound_file_with_a_style_for_all_that_it_draws(pages):
    for _, text, read in pages.values():
        ids = [element.attributes["id"] for element in read.elements if "id" in element.attributes]
        assert len({*ids}) == len(ids) and {element.attributes["for"] for element in read.all("label")} <= {*ids}
        assert {use.attributes["href"] for use in read.all("use")} <= {f"#{one}" for one in ids}
        assert not read.all("script") and not read.all("link") and "https://" not in text and "http://" not in text
        style = read.all("style")[0].text
        drawn = {name for element in read.elements if element.name in DRAWN for name in element.classes}
        assert {name for name in drawn if f".{name}" not in style} <= {"chance", "abstained", "unknown"}


def test_truth_is_drawn_in_its_own_layer_only(pages):
    truths = {"instance", "radius", "answer-star", "navigable", "mover", "change", "true", "of-category", "stem"}
    for _, _, read in pages.values():
        of_truth = [element for element in read.elements if truths & {*element.classes} and element.name != "span"]
        assert of_truth
        for element in of_truth:
            above, names = element.parent, set()
            while above is not None:
                names |= {*above.classes}
                above = above.parent
            assert names & {"truth", "of-truth"}, element


@pytest.mark.parametrize(("name", "split"), [("moved", "main"), ("multi", "multi"), ("everyday", "everyday")])
def test_every_arm_that_answers_the_split_has_the_verdicts_of_the_metrics(pages, name, split):
    episode, _, read = pages[name]
    arms = [BY_NAME[arm] for arm in CONFIG.splits[split].arms]
    rows = [row for row in read.all("tr") if "data-arm" in row.attributes]
    shown = list(dict.fromkeys(row.attributes["data-arm"] for row in rows))
    assert {*shown} == {arm.name for arm in arms} and episode.sentence in read.all("h1")[0].text
    for kind in Kind:
        controls = [BY_NAME[arm].control for arm in shown if BY_NAME[arm].kind is kind and arm not in shown_titles(RELEASED)]
        assert any(controls) and controls == sorted(controls)
    with (DATA / "metrics" / split / "static_outcomes.csv").open(newline="") as file:
        outcomes = [row for row in csv.DictReader(file) if row["episode"] == episode.id]
    for row in outcomes:
        (cells,) = read.all("tr", data_arm=row["arm"], data_run=row["seed"])
        verdict = {"abstained": "abstained", "expected": "chance"}.get(row["outcome"])
        assert cells.classes == [verdict or ("found" if float(row["success"]) else "missed")]
        assert row["outcome"] != "answered" or f"{float(row['distance_m']):.2f} m away" in cells.text
    for arm in (arm for arm in arms if arm.kind is Kind.EMBODIED):
        for run in RELEASED.runs(arm.name, episode):
            (cells,) = read.all("tr", data_arm=arm.name, data_run=str(run.seed))
            verdict = "abstained" if run.outcome == "abstained" else "found" if run.success else "missed"
            assert cells.classes == [verdict] and ("any instance" in cells.text) == (run.own_success is not None)


def test_few_arms_are_drawn_at_first_and_every_arm_can_be(pages):
    _, _, read = pages["moved"]
    first = {*shown_titles(RELEASED)}
    assert {CONFIG.comparisons.agent} < first and len(first) == 4
    boxes = {box.attributes["id"].removeprefix("arm-"): box for box in read.all("input", type="checkbox")}
    for name in BY_NAME:
        (drawn,) = read.of_class(f"arm-{name}")
        assert drawn.name == "g" and ("checked" in boxes[name].attributes) == (name in first)


def test_a_split_that_no_arm_answered_names_the_command(pages):
    assert "results/splits/dev" in pages["dev"][2].all("main")[0].text


def test_a_prediction_without_metrics_is_not_judged(few):
    root, record = few
    (row, *_) = Page(render_page(Results(root, CONFIG), Results(root, CONFIG).episodes[record["id"]])).of_class("unknown")
    assert "not judged here" in row.text


def test_everything_is_escaped(few):
    root, record = few
    evil = "<script>alert('x')</script> & \"y\" </svg></style>"
    thing = evil.replace("/", "")  # the id of an instance has no slash
    text = json.dumps(record | {"sentence": evil}).replace(json.dumps(record["target"])[1:-1], json.dumps(thing)[1:-1])
    (root / "episodes" / "main.jsonl").write_text(text + "\n")
    results = Results(root, CONFIG)
    text = render_page(results, results.episodes[record["id"]])
    read = Page(text)
    assert "<script" not in text and evil in read.all("h1")[0].text and thing in read.of_class("truth-box")[0].text


def test_evidence_of_other_maps_is_refused():
    cluster = Cluster(np.zeros(2), np.ones(2), np.zeros((1, 2)), np.zeros(1, int))
    episode = next(iter(RELEASED.episodes.values()))
    with pytest.raises(ShowError, match="the prediction of two_visits was made from other maps than these; `make tables`"):
        read_evidence(RELEASED, episode, {"first": [cluster], "second": [cluster]}, np.ones(2))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["FloorPlan1/moved/0001"], "no such episode: FloorPlan1/moved/0001; the nearest is"),
        ([], "or write --all"),
        (["--results", "nowhere", "--all"], "make tables"),
        (["--all", "--config", "nowhere.yaml"], "nowhere.yaml"),
        (["--all"], "main.jsonl: lacks FloorPlan"),
    ],
)
def test_the_command_says_in_one_line_why_it_cannot_show_an_episode(few, capsys, arguments, words):
    root, _ = few
    (root / "scenes" / "main.jsonl").unlink()
    assert cli.main(["show", *([] if "--results" in arguments else ["--results", str(root)]), *arguments]) == 1
    printed = capsys.readouterr()
    assert words in printed.err and printed.err.count("\n") == 1 and printed.out == ""
