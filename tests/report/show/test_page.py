from __future__ import annotations

import csv
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ovman.records.visit import seal
from ovman.report.show.page import page
from ovman.report.show.results import Results, ShowError
from ovman.settings import Kind, of_kind
from ovman.task import Relation
from tests.arms import REFERENCE
from tests.report.show.conftest import ROOT, SCENE
from tests.report.show.html_reader import Page

IDS = [f"{SCENE}/{relation}/0000" for relation in Relation]


@pytest.fixture(scope="module")
def pages(made, settings):
    results = Results(made, REFERENCE)
    return {name: page(results, name, settings) for name in IDS}


def _outcomes(made: Path, name: str) -> list[dict[str, str]]:
    with (made / "metrics" / "main" / name).open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("name", IDS)
def test_a_page_is_one_sound_file(pages, name):
    read = Page(pages[name])
    ids = [e.attributes["id"] for e in read.elements if "id" in e.attributes]
    assert len(set(ids)) == len(ids)
    assert {e.attributes["for"] for e in read.all("label")} <= set(ids)
    assert not read.all("script") and not read.all("link") and not read.all("iframe")
    for element in read.elements:
        for key in ("src", "href", "xlink:href"):
            assert (element.attributes.get(key) or "data:").startswith("data:")
    assert not re.search(r"url\(|@import|https?://", pages[name])


@pytest.mark.parametrize("name", IDS)
def test_every_class_of_a_drawing_has_a_style(pages, name):
    read = Page(pages[name])
    style = read.all("style")[0].text
    marks = ("circle", "rect", "path", "polyline", "text")
    drawn = {cls for e in read.elements if e.name in marks for cls in e.classes}
    assert {cls for cls in drawn if f".{cls}" not in style} <= {"chance", "abstained", "unknown"}


@pytest.mark.parametrize("name", IDS)
def test_a_page_has_the_sentence_the_answer_and_both_tours(made, pages, name):
    episode = Results(made, REFERENCE).episodes[name]
    read = Page(pages[name])
    words = read.all("body")[0].text
    assert episode.sentence in words
    assert f"The answer is ({episode.answer[0]:.2f}, {episode.answer[1]:.2f})" in words
    assert len(read.all("image")) == 8
    assert not read.of_class("absent")


@pytest.mark.parametrize("name", IDS)
def test_static_verdicts_are_those_of_the_metrics(made, pages, name):
    read = Page(pages[name])
    rows = [row for row in _outcomes(made, "static_outcomes.csv") if row["episode"] == name]
    static = of_kind(REFERENCE, Kind.STATIC)
    assert {row["arm"] for row in rows} == {arm.name for arm in static}
    assert all(len(read.all("tr", data_arm=arm.name)) == arm.runs for arm in static)
    for row in rows:
        shown = read.all("tr", data_arm=row["arm"])[int(row["seed"])]
        if row["outcome"] == "answered":
            assert shown.classes == ["found" if float(row["success"]) else "missed"]
            assert f"{float(row['distance_m']):.2f} m" in shown.text
        elif row["outcome"] == "expected":
            assert shown.classes == ["chance"] and f"{float(row['success']):.2f}" in shown.text
        else:
            assert shown.classes == ["abstained"]


@pytest.mark.parametrize("name", IDS)
def test_embodied_verdicts_are_those_of_the_metrics(made, pages, name):
    read = Page(pages[name])
    rows = [row for row in _outcomes(made, "embodied_outcomes.csv") if row["episode"] == name]
    assert len(rows) == 3 * len(of_kind(REFERENCE, Kind.EMBODIED))
    for row in rows:
        (shown,) = read.all("tr", data_arm=row["arm"], data_seed=row["seed"])
        expected = "abstained" if row["outcome"] == "abstained" else "found" if row["success"] == "1" else "missed"
        assert shown.classes == [expected]


@pytest.mark.parametrize("name", IDS)
def test_truth_is_drawn_in_its_own_layer_only(pages, name):
    read = Page(pages[name])
    truths = {"instance", "radius", "answer-star", "navigable", "mover", "change", "true", "of-category", "stem"}
    of_truth = [e for e in read.elements if truths & set(e.classes) and e.name != "span"]
    assert of_truth
    for element in of_truth:
        above, inside = element.parent, False
        while above is not None:
            inside |= bool({"truth", "of-truth"} & set(above.classes))
            above = above.parent
        assert inside, element


@pytest.mark.parametrize("name", IDS)
def test_own_and_handed_evidence_agree_where_perception_is_right(pages, name):
    """The detector of the fixture has no faults: its maps have the chairs where they are handed over."""
    read = Page(pages[name])
    assert [e.text for e in read.all("label") if e.attributes["for"].startswith("evidence-")] == [
        "own maps, own grounding (react_two_visits)",
        "own maps, own grounding (two_visits)",
        "own maps, oracle grounding",
        "oracle positions",
    ]
    if not name.endswith("moving/0000"):
        tables = [e.text for e in read.all("table") if e.parent and "three" in e.parent.classes]
        pairs = [re.findall(r"\d+\.\d\d m", text)[1::2] for text in tables[0::3]]
        assert len(pairs) == 4 and pairs[1] == pairs[2] == pairs[3]


def test_equal_files_make_equal_pages(made, settings, pages):
    program = (
        "import sys; from pathlib import Path; from ovman.settings import config; from ovman.report.show.page import page;"
        "from ovman.report.show.results import Results; from tests.arms import REFERENCE;"
        "sys.stdout.reconfigure(encoding='utf-8', newline='\\n');"
        "sys.stdout.write(page(Results(Path(sys.argv[1]), REFERENCE), sys.argv[2], config.load(sys.argv[3])))"
    )
    environment = os.environ | {"PYTHONHASHSEED": "7", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", program, str(made), IDS[0], str(ROOT / "config.yaml")]
    again = subprocess.run(command, env=environment, capture_output=True, check=True).stdout.decode("utf-8")
    assert again == pages[IDS[0]]


def test_everything_is_escaped(tmp_path, made, settings):
    """Whatever a record says comes out as words."""
    evil = "<script>alert('x')</script> & \"y\" </svg></style>"
    thing = evil.replace("/", "")  # the id of an instance has no slash
    root = tmp_path / "results"
    shutil.copytree(made, root)

    def spoil(text: str) -> str:
        return text.replace("Chair|a", json.dumps(thing)[1:-1]).replace("go to the chair of", json.dumps(evil)[1:-1])

    for path in [*root.rglob("*.json"), *root.rglob("*.jsonl")]:
        path.write_text(spoil(path.read_text()))
    for path in root.rglob("visit.json"):
        seal(path.parent)
    for name in IDS:
        text = page(Results(root, REFERENCE), name, settings)
        read = Page(text)
        assert not read.all("script") and "<script" not in text
        assert evil in read.all("h1")[0].text
        assert thing in "".join(read.of_class("truth-box")[0].words)


@pytest.mark.parametrize(
    ("gone", "words", "command"),
    [
        ("visits", "No recorded tours here", f"results/visits/{SCENE}.json"),
        ("detections", "No detections here", f"results/detections/{SCENE}.npz"),
        ("maps", "No maps here", f"results/maps/{SCENE}.npz"),
        ("nouns.npz", "No embedding of “chair” here", "results/nouns.npz"),
        ("predictions", "No evidence of any arm", "make tables"),
        ("metrics", "not judged yet", "make tables"),
        ("scores", "no run here", "make tables"),
        ("episodes/sightings.jsonl", "", ""),
    ],
)
def test_what_is_absent_is_named(tmp_path, made, settings, gone, words, command):
    root = tmp_path / "results"
    shutil.copytree(made, root)
    (shutil.rmtree if (root / gone).is_dir() else Path.unlink)(root / gone)
    read = Page(page(Results(root, REFERENCE), IDS[0], settings))
    assert words in read.all("main")[0].text and command in read.all("main")[0].text


def test_evidence_of_other_maps_is_refused(tmp_path, made, settings):
    root = tmp_path / "results"
    shutil.copytree(made, root)
    path = root / "predictions" / "two_visits.jsonl"
    answered = [json.loads(text) for text in path.read_text().splitlines()]
    answered[0]["evidence"]["grounded"]["second"].append(99)
    path.write_text("".join(json.dumps(record) + "\n" for record in answered))
    with pytest.raises(ShowError, match="two_visits was made from other maps"):
        page(Results(root, REFERENCE), answered[0]["episode"], settings)
