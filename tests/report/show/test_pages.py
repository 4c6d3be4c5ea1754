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
from tests.report.show.pages import classes, of_class, read, words

RELEASED = Results(DATA, CONFIG)
DRAWN = frozenset({"circle", "rect", "path", "polyline", "text", "use"})
TRUTHS = frozenset({"instance", "radius", "answer-star", "navigable", "mover", "change", "true", "of-category", "stem"})


@pytest.fixture(scope="module")
def pages():
    """Episode, text and root of the pages of an episode of each relation in split main, and of one of each split; by either."""
    episodes = RELEASED.episodes.values()
    chosen = {e.relation.value: e for e in episodes if e.split == "main"} | {e.split: e for e in episodes if e.split != "main"}
    texts = {name: render_page(RELEASED, episode) for name, episode in chosen.items()}
    return {name: (chosen[name], text, read(text)) for name, text in texts.items()}


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
    for _, text, root in pages.values():
        ids = [element.get("id") for element in root.iter() if element.get("id")]
        assert len({*ids}) == len(ids) and {element.get("for") for element in root.iter("label")} <= {*ids}
        assert {use.get("href") for use in root.iter("use")} <= {f"#{one}" for one in ids}
        assert root.find(".//script") is None and root.find(".//link") is None and "://" not in text
        style, drawn = words(root.find("head/style")), [element for element in root.iter() if element.tag in DRAWN]
        unstyled = {name for element in drawn for name in classes(element) if f".{name}" not in style}
        assert unstyled <= {"chance", "abstained", "unknown"}


def test_truth_is_drawn_in_its_own_layer_only(pages):
    for _, _, root in pages.values():
        of_truth = [element for element in root.iter() if TRUTHS & classes(element)]
        layers = of_class(root, "truth") + of_class(root, "of-truth")
        assert of_truth and {*of_truth} <= {element for layer in layers for element in layer.iter()}


@pytest.mark.parametrize(("name", "split"), [("moved", "main"), ("multi", "multi"), ("everyday", "everyday")])
def test_every_arm_that_answers_the_split_has_the_verdicts_of_the_metrics(pages, name, split):
    episode, _, root = pages[name]
    released = {path.stem for stage in ("predictions", "scores") for path in (DATA / stage / split).glob("*.jsonl")}
    arms = [BY_NAME[arm] for arm in CONFIG.splits[split].arms if arm in released]
    rows = {(row.get("data-arm"), row.get("data-run")): row for row in root.iter("tr") if row.get("data-arm")}
    shown = list(dict.fromkeys(arm for arm, _ in rows))
    assert {*shown} == {arm.name for arm in arms} and episode.sentence in words(root.find(".//h1"))
    for kind in Kind:
        controls = [BY_NAME[arm].control for arm in shown if BY_NAME[arm].kind is kind and arm not in shown_titles(RELEASED)]
        assert any(controls) and controls == sorted(controls)
    with (DATA / "metrics" / split / "static_outcomes.csv").open(newline="") as file:
        outcomes = [row for row in csv.DictReader(file) if row["episode"] == episode.id]
    for row in outcomes:
        cells = rows[row["arm"], row["seed"]]
        verdict = {"abstained": "abstained", "expected": "chance"}.get(row["outcome"])
        assert cells.get("class") == (verdict or ("found" if float(row["success"]) else "missed"))
        assert row["outcome"] != "answered" or f"{float(row['distance_m']):.2f} m away" in words(cells)
    for arm in (arm for arm in arms if arm.kind is Kind.EMBODIED):
        for run in RELEASED.runs(arm.name, episode):
            cells = rows[arm.name, str(run.seed)]
            verdict = "abstained" if run.outcome == "abstained" else "found" if run.success else "missed"
            assert cells.get("class") == verdict and ("any instance" in words(cells)) == (run.own_success is not None)


def test_a_prediction_without_metrics_is_not_judged(few):
    root, record = few
    results = Results(root, CONFIG)
    rows = of_class(read(render_page(results, results.episodes[record["id"]])), "unknown")
    assert rows and all("not judged here" in words(row) for row in rows if row.tag == "tr")


def test_everything_is_escaped(few):
    root, record = few
    evil = "<script>alert('x')</script> & \"y\" </svg></style>"
    thing = evil.replace("/", "")  # the id of an instance has no slash
    text = json.dumps(record | {"sentence": evil}).replace(json.dumps(record["target"])[1:-1], json.dumps(thing)[1:-1])
    (root / "episodes" / "main.jsonl").write_text(text + "\n")
    results = Results(root, CONFIG)
    text = render_page(results, results.episodes[record["id"]])
    page = read(text)
    assert "<script" not in text and evil in words(page.find(".//h1")) and thing in words(*of_class(page, "truth-box"))


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


def test_an_episode_of_a_split_that_the_settings_lack_has_the_same_answers():
    without = Results(DATA, CONFIG.model_copy(update={"splits": {k: v for k, v in CONFIG.splits.items() if k != "multi"}}))
    assert without.episodes == RELEASED.episodes
    episode = next(one for one in RELEASED.episodes.values() if one.split == "multi")
    arms = [
        {e.get("data-arm") for e in read(render_page(one, episode)).iter() if e.get("data-arm")} for one in (without, RELEASED)
    ]
    assert arms[0] == arms[1] != set()
