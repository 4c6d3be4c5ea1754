"""`ovman show` where no result has a tour: it records it and detects objects in it, and shows the runs of evaluations."""

from __future__ import annotations

import shutil
from argparse import Namespace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from ovman import cli
from ovman.playback import show
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.records.scene import Scene
from ovman.report.show.film import GAP_PX, PANEL_PX, plan_frame
from tests.entry.evaluations import SCENE, lines
from tests.episodes import DATA, ROOT, of_scene
from tests.report.show.pages import of_class, read, words
from tests.report.show.test_gallery import read_gallery

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


def test_a_gallery_has_the_verdicts_of_an_evaluation(tmp_path, depth_driving):
    named = ["--results", str(DATA), "--config", str(ROOT / "config.yaml"), "--out", str(tmp_path)]
    assert cli.main(["gallery", "--split", "main", *named, "--runs", str(depth_driving)]) == 0
    page = read_gallery((tmp_path / "index.html").read_text())
    agents = page.find(".//form").get("data-agents").split("|")
    runs = Score.read(depth_driving / "runs.jsonl")
    found = {name: all(run.success for run in runs if run.episode == name) for name in {run.episode for run in runs}}
    (own,) = [k for k, agent in enumerate(agents) if str(depth_driving) in agent]
    shown = {card.get("aria-labelledby"): card.find("ol/li").get("data-found")[own] for card in page.iter("article")}
    assert {name: sign == "1" for name, sign in shown.items() if sign != "-"} == found


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """A short released run on everyday, its episode, its scene, the pictures of its film, and the file."""
    runs = Score.read(DATA / "scores" / "everyday" / "joint_embodied.jsonl")
    run = min((run for run in runs if run.success and run.path_length_m > 1 and run.seed == 0), key=lambda run: run.actions)
    episode = next(one for one in Episode.load(DATA / "episodes" / "everyday.jsonl") if one.id == run.episode)
    scene = next(one for one in Scene.read(DATA / "scenes" / "everyday.jsonl") if one.scene == episode.scene)
    file = tmp_path_factory.mktemp("film") / "run.webp"
    options = ["--results", str(DATA), "--config", str(ROOT / "config.yaml"), "--arm", run.arm, "--seed", "0"]
    assert cli.main(["show", episode.id, "--video", str(file), *options]) == 0
    pictures = []
    with Image.open(file) as image:
        for number in range(image.n_frames):
            image.seek(number)
            pictures.append((np.asarray(image.convert("RGB"), int), image.info["duration"]))
    return run, episode, scene, pictures, file


def test_a_film_is_short_and_shows_each_action(film):
    run, _, _, pictures, file = film
    assert len(pictures) == run.actions + 2  # the spawn, each action, and the end
    assert sum(lasting for _, lasting in pictures) <= 15_000 and file.stat().st_size < 3_000_000
    assert all(np.abs(one - other)[:300, :300].mean() > 1 for (one, _), (other, _) in pairwise(pictures[:-1]))


def test_the_last_picture_shows_the_stop(film):
    """The mark of the agent turns green where the record has the stop; before it stood elsewhere or was blue."""
    run, episode, scene, pictures, _ = film
    x, y = plan_frame(scene, episode).at((run.stop.x, run.stop.z))
    u, v = round(x) + PANEL_PX + 2 * GAP_PX, round(y) + GAP_PX
    (red, green, blue), before = pictures[-1][0][v, u], pictures[-2][0][v, u]
    assert green > red + 60 and green > blue and before[2] > before[1] + 30


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--video", "a.mp4"], "write a name that ends in .webp"),
        (["--video", "a.webp", "--arm", "nobody"], "no recorded run of arm nobody; there: "),
        (["--video", "a.webp", "--all"], "a film shows one episode"),
        (["--arm", "joint_embodied"], "add --video"),
    ],
)
def test_the_command_says_in_one_line_why_there_is_no_film(tmp_path, monkeypatch, capsys, arguments, says):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["show", EPISODE.id, "--results", str(DATA), "--config", str(ROOT / "config.yaml"), *arguments]) == 1
    printed = capsys.readouterr()
    assert says in printed.err and printed.err.count("\n") == 1 and not [*tmp_path.iterdir()]
