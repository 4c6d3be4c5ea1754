"""A page shows every run of an arm that answers otherwise each time, and the verdict on a task of an agent's own."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from ovman.analysis.metrics import write_metrics
from ovman.report.show.index import index
from ovman.report.show.page import page
from ovman.report.show.results import Results
from ovman.settings import Kind
from ovman.settings.arms import ArmJob
from tests.arms import REFERENCE
from tests.report.show.conftest import SCENE
from tests.report.show.html_reader import Page

MAP = ArmJob(name="some_map", kind=Kind.STATIC, agent="x:y", system="a map", memory="maintained map", runs=3)
NAVIGATOR = ArmJob(name="navigator", kind=Kind.EMBODIED, agent="x:y", system="a navigator", memory="second visit")
ARMS = (MAP, *REFERENCE, NAVIGATOR)
NAME = f"{SCENE}/moved/0000"


@pytest.fixture(scope="module")
def results(tmp_path_factory, made, settings):
    """The results of the other tests and two arms more: one right in its run 1 alone, one that reaches any instance alone."""
    root = tmp_path_factory.mktemp("several") / "results"
    shutil.copytree(made, root)
    episodes = [json.loads(line) for line in (root / "episodes" / "main.jsonl").read_text().splitlines()]
    lines = []
    for number in (2, 0, 1):
        for episode in episodes:
            answer = episode["answer"]
            at = {"x": answer["x"] + 3.0 * (number == 0), "z": answer["z"]}
            outcome = {"abstain": "nothing_grounded"} if number == 2 else at
            lines.append({"schema": "ovman-prediction/1", "episode": episode["id"], "arm": MAP.name, "seed": number, **outcome})
    (root / "predictions" / f"{MAP.name}.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    run = {
        "schema": "ovman-run/1",
        "arm": NAVIGATOR.name,
        "seed": 0,
        "outcome": "stopped",
        "success": False,
        "spl": 0.0,
        "stop": {"x": 1.0, "z": 1.0, "yaw_deg": 0.0},
        "box_distance_m": 2.0,
        "answer_distance_m": 2.0,
        "navigable_distance_m": 2.0,
        "visible_px": {"0": 40, "30": 7},
        "path_length_m": 4.0,
        "actions": 9,
    }
    place = root / "scores" / NAVIGATOR.name / "seed0" / f"{SCENE}.jsonl"
    place.parent.mkdir(parents=True)
    place.write_text("".join(json.dumps(run | {"episode": e["id"], "own_success": e["id"] == NAME}) + "\n" for e in episodes))
    constants = SimpleNamespace(
        **{name: getattr(settings, name) for name in type(settings).model_fields} | {"arms": {arm.name: arm for arm in ARMS}}
    )
    files = sorted((root / "predictions").glob("*.jsonl")), sorted((root / "scores").rglob("*.jsonl"))
    write_metrics(root / "episodes" / "main.jsonl", *files, constants, root / "metrics" / "main")
    return Results(root, ARMS)


def test_every_run_has_a_row_and_a_mark_of_its_own(results, settings):
    read = Page(page(results, NAME, settings))
    rows = read.all("tr", data_arm=MAP.name)
    assert [row.classes for row in rows] == [["missed"], ["found"], ["abstained"]]
    assert [row.attributes["data-run"] for row in rows] == ["0", "1", "2"]
    cells = [[cell for cell in read.all("td") if cell.parent is row] for row in rows]
    assert [row[0].text for row in cells] == ["A0", "A1", "A2"] and [row[-4].text for row in cells] == ["0", "1", "2"]
    # What they have in common is said once, beside all of them.
    assert [len(row) for row in cells] == [6, 5, 5]
    assert "a map" in cells[0][1].text and cells[0][1].attributes["rowspan"] == "3"
    marks = " ".join(text for e in read.of_class("pill-text") for text in e.words)
    # A1 stands where other arms are right, too; an abstention stands nowhere.
    assert "A0 ✗" in marks and "A1" in marks.split() and "A2" not in marks
    assert all(len(read.all("tr", data_arm=arm.name)) == arm.runs for arm in REFERENCE if arm.kind is Kind.STATIC)


def test_an_agents_own_task_is_told_beside_its_stop(results, settings):
    def words(name):
        (row,) = Page(page(results, name, settings)).all("tr", data_arm=NAVIGATOR.name)
        return row.text

    assert "any instance: found" in words(NAME) and "any instance: missed" in words(f"{SCENE}/removed/0000")
    read = Page(page(results, NAME, settings))
    assert "sees 40 px" in words(NAME) and "sees" not in words(f"{SCENE}/removed/0000")
    assert any("arm’s own task" in note.text for note in read.of_class("note"))
    (other,) = read.all("tr", data_arm="oracle_check", data_seed="0")
    assert "any instance" not in other.text


def test_the_index_has_a_column_an_arm_and_a_mark_a_run(results):
    read = Page(index(results, [NAME], [Path("page.html")]))
    (row,) = [row for row in read.all("tr") if NAME in row.text]
    cells = [cell for cell in read.all("td") if cell.parent is row]
    assert len(cells) == 2 + len(ARMS)
    assert "".join(cells[2].text.split()) == "✗✓–"
