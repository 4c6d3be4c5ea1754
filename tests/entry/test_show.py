"""`ovman show` where no result has a tour: it records it and detects objects in it, and shows the runs of evaluations."""

from __future__ import annotations

import shutil
from argparse import Namespace

import pytest

from ovman.playback import show
from ovman.records.run import Score
from tests.entry.evaluations import SCENE, lines
from tests.episodes import DATA, ROOT, of_scene
from tests.report.show.html_reader import Page

EPISODE = of_scene(SCENE)[0]


def options(**given) -> Namespace:
    """The options of `ovman show` for the episode."""
    defaults = {"episodes": [EPISODE.id], "all": False, "results": None, "output": None, "config": ROOT / "config.yaml"}
    return Namespace(**defaults | given)


@pytest.fixture(scope="module")
def shown(tmp_path_factory, tours, depth_driving):
    """The page of an episode that the results lack and the release has, and what was said while it was made, twice."""
    here = tmp_path_factory.mktemp("show")
    (here / "results" / "episodes").mkdir(parents=True)
    (here / "results" / "episodes" / "main.jsonl").write_text(
        "".join(one.to_line() for one in of_scene("FloorPlan201")), encoding="utf-8"
    )
    said: list[list[str]] = [[], []]
    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(here)
        for one in said:
            (path,) = show(options(output=here / "page.html", runs=[depth_driving]), one.append, tours)
    return Page(path.read_text(encoding="utf-8")), said


def test_tours_are_recorded_and_looked_at_once(shown):
    read, (first, second) = shown
    views = sum(len(tour.waypoints) * tour.headings for tour in (EPISODE.tours.first, EPISODE.tours.second))
    assert len(read.all("image")) == views and read.of_class("mask")
    assert sum("detecting" in line for line in first) == 1 and second == []


def test_maps_are_those_that_the_release_answered_from(shown):
    """The evidence of released predictions names objects by their number in a map."""
    read, _ = shown
    assert [e for e in read.of_class("object") if "grounded" in e.classes and e.name == "circle"]
    assert [e for e in read.of_class("mask") if "grounded" in e.classes] and "matched" in read.of_class("evidence")[0].text


def test_runs_of_an_evaluation_have_a_path_and_a_verdict(shown, depth_driving):
    read, _ = shown
    runs = [run for run in Score.read(depth_driving / "runs.jsonl") if run.episode == EPISODE.id]
    assert len(runs) == 2 and len(read.of_class("drive")) == 2
    for run in runs:
        (row,) = read.all("tr", data_arm="own-0", data_run=str(run.seed))
        assert row.classes == ["found" if run.success else "missed"] and f"{run.actions} actions" in row.text


def test_an_evaluation_without_the_episode_is_said(tmp_path, tours, depth_driving):
    other, said = shutil.copytree(depth_driving, tmp_path / "other"), []
    (other / "runs.jsonl").write_text("".join(f"{line}\n" for line in lines(other / "runs.jsonl") if EPISODE.id not in line))
    assert [*show(options(results=DATA, output=tmp_path / "a.html", runs=[other]), said.append, tours)]
    assert any("no run of" in line for line in said)
