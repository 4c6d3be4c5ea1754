"""Pages of released episodes: sound HTML, the verdicts of the metrics, truth in its own layer, words for missing files."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from ovman import cli
from ovman.perception.clusters import Cluster
from ovman.playback import places
from ovman.records.prediction import Prediction
from ovman.report.show.answers import count_in_letters
from ovman.report.show.page import index, list_shown, page
from ovman.report.show.reasoning import read_maps
from ovman.report.show.results import Results, ShowError
from ovman.settings import Kind, arms_of
from tests.arms import ARMS, BY_NAME, CONFIG
from tests.episodes import DATA, ROOT
from tests.report.show.html_reader import Page

SPLITS = ("main", "multi", "everyday")
DRAWN = frozenset({"circle", "rect", "path", "polyline", "text"})


@pytest.fixture(scope="module")
def released() -> Results:
    """The release, as `ovman show` reads it without results of its own."""
    return places(DATA, None, ROOT / "config.yaml")[1]


@pytest.fixture(scope="module")
def ids(released) -> dict[str, str]:
    """One episode of each relation of split main and one of each other split, by relation or split."""
    of_main = {episode.relation.value: name for name, episode in released.episodes.items() if episode.split == "main"}
    return of_main | {episode.split: name for name, episode in released.episodes.items() if episode.split != "main"}


@pytest.fixture(scope="module")
def pages(released, ids) -> dict[str, str]:
    return {name: page(released, name, CONFIG) for name in ids.values()}


@pytest.fixture
def few(tmp_path) -> Path:
    """A release with the first episode of split main alone, to be changed."""
    root = tmp_path / "results"
    for stage in ("episodes", "sightings", "predictions", "scores", "metrics"):
        shutil.copytree(DATA / stage, root / stage, ignore=lambda _, names: [one for one in names if one in SPLITS[1:]])
    (first, *_) = (root / "episodes" / "main.jsonl").read_text().splitlines()
    name = json.loads(first)["id"]
    for path in root.rglob("*.jsonl"):
        rows = [
            line for line in path.read_text().splitlines() if name in (json.loads(line).get(key) for key in ("id", "episode"))
        ]
        path.write_text("".join(f"{line}\n" for line in rows))
    scenes = (DATA / "scenes" / "main.jsonl").read_text().splitlines()
    (root / "scenes").mkdir()
    (root / "scenes" / "main.jsonl").write_text("".join(f"{one}\n" for one in scenes if json.loads(one)["scene"] in name))
    return root


def test_a_page_is_one_sound_file_with_a_style_for_all_that_it_draws(pages):
    for text in pages.values():
        read = Page(text)
        ids = [element.attributes["id"] for element in read.elements if "id" in element.attributes]
        assert len({*ids}) == len(ids) and {element.attributes["for"] for element in read.all("label")} <= {*ids}
        assert not read.all("script") and not read.all("link") and "https://" not in text and "http://" not in text
        style = read.all("style")[0].text
        drawn = {name for element in read.elements if element.name in DRAWN for name in element.classes}
        assert {name for name in drawn if f".{name}" not in style} <= {"chance", "abstained", "unknown"}


def test_truth_is_drawn_in_its_own_layer_only(pages):
    truths = {"instance", "radius", "answer-star", "navigable", "mover", "change", "true", "of-category", "stem"}
    for text in pages.values():
        of_truth = [element for element in Page(text).elements if truths & {*element.classes} and element.name != "span"]
        assert of_truth
        for element in of_truth:
            above, names = element.parent, set()
            while above is not None:
                names |= {*above.classes}
                above = above.parent
            assert names & {"truth", "of-truth"}, element


def test_every_arm_that_answers_the_split_has_the_verdicts_of_the_metrics(released, ids, pages):
    for split in SPLITS:
        name = ids.get(split, ids["moved"])
        episode, read = released.episodes[name], Page(pages[name])
        with (DATA / "metrics" / split / "static_outcomes.csv").open(newline="") as file:
            outcomes = [row for row in csv.DictReader(file) if row["episode"] == name]
        arms = [arm for arm in ARMS if split == "main" or arm.name in CONFIG.splits[split].arms]
        shown = [row.attributes["data-arm"] for row in read.all("tr") if "data-arm" in row.attributes]
        assert {*shown} == {arm.name for arm in arms} and episode.sentence in read.all("h1")[0].text
        for row in outcomes:
            cells = read.all("tr", data_arm=row["arm"])[int(row["seed"])]
            verdict = {"abstained": "abstained", "expected": "chance"}.get(row["outcome"])
            assert cells.classes == [verdict or ("found" if float(row["success"]) else "missed")]
            assert row["outcome"] != "answered" or f"{float(row['distance_m']):.2f} m" in cells.text
        for arm in (arm for arm in arms if arm.kind is Kind.EMBODIED):
            for seed, run in released.runs(arm.name, episode).items():
                (cells,) = read.all("tr", data_arm=arm.name, data_seed=str(seed))
                verdict = "abstained" if run.outcome == "abstained" else "found" if run.success else "missed"
                assert cells.classes == [verdict] and ("any instance" in cells.text) == (run.own_success is not None)


def test_controls_stand_below_all_systems(ids, pages):
    read = Page(pages[ids["moved"]])
    shown = [row.attributes["data-arm"] for row in read.all("tr") if "data-arm" in row.attributes]
    for kind in Kind:
        controls = [BY_NAME[name].control for name in shown if BY_NAME[name].kind is kind]
        assert any(controls) and controls == sorted(controls)


def test_few_arms_are_drawn_at_first_and_every_arm_can_be(ids, pages):
    read, first = Page(pages[ids["moved"]]), {*list_shown(CONFIG)}
    assert {CONFIG.comparisons.agent} < first and len(first) == 4
    boxes = {box.attributes["id"].removeprefix("arm-"): box for box in read.all("input", type="checkbox")}
    for arm in ARMS:
        (drawn,) = read.of_class(f"arm-{arm.name}")
        assert drawn.name == "g" and ("checked" in boxes[arm.name].attributes) == (arm.name in first)


def test_an_arm_with_several_runs_has_a_row_and_a_mark_per_run(released, ids, pages):
    (arm, *_) = (arm for arm in ARMS if arm.runs > 1 and arm.kind is Kind.STATIC)
    rows = Page(pages[ids["moved"]]).all("tr", data_arm=arm.name)
    assert [row.attributes["data-run"] for row in rows] == [str(run) for run in range(arm.runs)]
    read = Page(index(released, [ids["moved"]], [Path("page.html")]))
    (row,) = [row for row in read.all("tr") if ids["moved"] in row.text]
    cells = [cell for cell in read.all("td") if cell.parent is row]
    assert len(cells) == 2 + len(ARMS) and read.all("a")[0].attributes["href"] == "page.html"
    assert max(len(cell.text.split()) for cell in cells[2:]) == arm.runs


@pytest.mark.parametrize(
    ("gone", "words"),
    [
        ("visits", "No recorded tours here: “snakemake --cores 2 -- results/visits/main.jsonl” records them."),
        ("maps", "No maps here: “snakemake --cores 2 -- results/maps/main” makes them."),
        ("predictions", "no prediction here: “make tables” makes it"),
        ("metrics", "not judged yet: “make tables” judges it"),
        ("scores", "no run here: “make tables” makes it"),
        ("sightings", "No evidence of any arm here: “make tables” records it."),
    ],
)
def test_a_missing_file_is_named_with_its_command(few, gone, words):
    shutil.rmtree(few / gone, ignore_errors=True)
    results = Results(few, ARMS)
    (name,) = results.episodes
    assert words in Page(page(results, name, CONFIG)).all("main")[0].text


def test_a_split_that_no_arm_answered_names_its_own_command(pages, ids):
    words = Page(pages[ids["dev"]]).all("main")[0].text
    assert "results/splits/dev" in words and "make tables" not in words


def test_everything_is_escaped(few):
    evil = "<script>alert('x')</script> & \"y\" </svg></style>"
    path = few / "episodes" / "main.jsonl"
    record = json.loads(path.read_text())
    thing = evil.replace("/", "")  # the id of an instance has no slash
    for file in few.rglob("*.jsonl"):
        file.write_text(file.read_text().replace(json.dumps(record["target"])[1:-1], json.dumps(thing)[1:-1]))
    record = json.loads(path.read_text()) | {"sentence": evil}
    path.write_text(json.dumps(record) + "\n")
    text = page(Results(few, ARMS), record["id"], CONFIG)
    read = Page(text)
    assert "<script" not in text and evil in read.all("h1")[0].text and thing in read.of_class("truth-box")[0].text


def test_evidence_of_other_maps_is_refused():
    cluster = Cluster(np.zeros(2), np.ones(2), np.zeros((1, 2)), np.zeros(1, int))
    line = {"schema": "ovman-prediction/1", "episode": "a", "arm": "two_visits", "seed": 0, "x": 0.0, "z": 0.0}
    evidence = {"grounded": {"first": [0], "second": [1]}, "pairs": []}
    prediction = Prediction.parse(json.dumps(line | {"evidence": evidence}))
    with pytest.raises(ShowError, match="a: the prediction of two_visits was made from other maps than these; `make tables`"):
        read_maps(BY_NAME["two_visits"], [[cluster], [cluster]], prediction, None, CONFIG)


def test_letters_do_not_run_out():
    names = [count_in_letters(number) for number in range(1000)]
    assert len({*names}) == 1000
    assert (names[0], names[25], names[26], names[27], names[52], names[702]) == ("A", "Z", "AA", "AB", "BA", "AAA")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["FloorPlan1/moved/0001"], "no such episode: FloorPlan1/moved/0001; the nearest is"),
        ([], "or write --all"),
        (["--results", "nowhere", "--all"], "make tables"),
        (["--all", "--config", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_the_command_says_in_one_line_why_it_cannot_show_an_episode(few, capsys, arguments, words):
    given = [*arguments, *([] if "--results" in arguments else ["--results", str(few)])]
    given += [] if "--config" in arguments else ["--config", str(ROOT / "config.yaml")]
    assert cli.main(["show", *given]) == 1
    printed = capsys.readouterr()
    assert words in printed.err and printed.err.count("\n") == 1 and printed.out == ""


def test_a_missing_scene_is_named(few):
    (few / "scenes" / "main.jsonl").write_text("")
    results = Results(few, arms_of(CONFIG.arms))
    with pytest.raises(ShowError, match="main.jsonl lacks FloorPlan"):
        page(results, next(iter(results.episodes)), CONFIG)
