"""`ovman show` where no result has a tour or a map: it records and looks at both, and shows the runs of evaluations."""

from __future__ import annotations

import shutil

import pytest

from ovman.playback import show
from ovman.records.run import Score
from tests.entry.evaluations import SCENE, lines
from tests.episodes import DATA, ROOT, of_scene
from tests.report.show.html_reader import Page

EPISODE = of_scene(SCENE)[0]


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
            runs, config = [depth_driving], ROOT / "config.yaml"
            (path,) = show([EPISODE.id], False, None, here / "page.html", config, runs, one.append, cache=tours)
    return Page(path.read_text(encoding="utf-8")), said


def test_tours_are_recorded_and_looked_at_once(shown):
    read, (first, second) = shown
    views = sum(len(tour.waypoints) * tour.headings for tour in (EPISODE.tours.first, EPISODE.tours.second))
    assert len(read.all("image")) == views and read.of_class("mask")
    assert not read.of_class("absent")
    assert any("detecting" in line for line in first) and second == []


def test_maps_are_those_that_the_release_answered_from(shown):
    """The evidence of released predictions names objects by their number in a map."""
    read, _ = shown
    assert [e for e in read.of_class("object") if "grounded" in e.classes]
    assert "two_visits" in " ".join(e.text for e in read.all("label"))


def test_runs_of_an_evaluation_have_a_path_and_a_verdict(shown, depth_driving):
    read, _ = shown
    runs = [run for run in Score.read(depth_driving / "runs.jsonl") if run.episode == EPISODE.id]
    assert len(runs) == 2 and len([path for path in read.of_class("drive") if path.parent.name == "g"]) == 2
    for run in runs:
        (row,) = [row for row in read.all("tr", data_own=run.arm) if row.attributes["data-seed"] == str(run.seed)]
        assert row.classes == ["found" if run.success else "missed"] and f"{run.actions} actions" in row.text


def test_an_evaluation_without_the_episode_is_said(tmp_path, tours, depth_driving):
    other, said = shutil.copytree(depth_driving, tmp_path / "other"), []
    (other / "runs.jsonl").write_text("".join(f"{line}\n" for line in lines(other / "runs.jsonl") if EPISODE.id not in line))
    assert [*show([EPISODE.id], False, DATA, tmp_path / "a.html", None, [other], said.append, tours)]
    assert any("no run of" in line for line in said)
