"""`ovman show` where no result has a tour: it records it and detects objects in it, and shows the runs of evaluations."""

from __future__ import annotations

import shutil
from argparse import Namespace

import pytest

from ovman.playback import show
from ovman.records.run import Score
from tests.entry.evaluations import SCENE, lines
from tests.episodes import DATA, ROOT, of_scene
from tests.report.show.pages import of_class, read, words

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
    return read(path.read_text(encoding="utf-8")), said


def test_tours_are_recorded_and_looked_at_once(shown):
    page, (first, second) = shown
    views = sum(len(tour.waypoints) * tour.headings for tour in (EPISODE.tours.first, EPISODE.tours.second))
    assert len([*page.iter("image")]) == views and of_class(page, "mask")
    assert sum("detecting" in line for line in first) == 1 and second == []


def test_maps_are_those_that_the_release_answered_from(shown):
    """The evidence of released predictions names objects by their number in a map."""
    page, _ = shown
    assert any(e.tag == "circle" for e in of_class(page, "object", "grounded"))
    assert of_class(page, "mask", "grounded") and "matched" in words(*of_class(page, "evidence"))


def test_runs_of_an_evaluation_have_a_path_and_a_verdict(shown, depth_driving):
    page, _ = shown
    runs = [run for run in Score.read(depth_driving / "runs.jsonl") if run.episode == EPISODE.id]
    assert len(runs) == 2 and len(of_class(page, "drive")) == 2
    for run in runs:
        (row,) = page.findall(f".//tr[@data-arm='own-0'][@data-run='{run.seed}']")
        assert row.get("class") == ("found" if run.success else "missed") and f"{run.actions} actions" in words(row)


def test_an_evaluation_without_the_episode_is_said(tmp_path, tours, depth_driving):
    other, said = shutil.copytree(depth_driving, tmp_path / "other"), []
    (other / "runs.jsonl").write_text("".join(f"{line}\n" for line in lines(other / "runs.jsonl") if EPISODE.id not in line))
    assert [*show(options(results=DATA, output=tmp_path / "a.html", runs=[other]), said.append, tours)]
    assert any("no run of" in line for line in said)
