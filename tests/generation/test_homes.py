"""A split in a home, from its scene to an evaluation and its verification: the stages of the workflow, on few draws."""

from __future__ import annotations

import pytest

from ovman.cache import Cache
from ovman.generation import candidates, certification, release, scenes, trials, verdict
from ovman.records.episode import Episode
from ovman.settings.config import load
from ovman.sim.scenes import load_scene
from tests.entry.evaluations import DEPTH, command
from tests.shared import made_once
from tests.test_config import SPLIT, changed

NONE = dict.fromkeys(SPLIT["draws"], 0)
SETTINGS = load(
    changed(
        {
            "splits.own": SPLIT
            | {
                "homes": {"seed": 4, "count": 1, "rooms": [1], "assets": "test"},
                "episodes": NONE | {"removed": 1},
                "draws": NONE | {"removed": 2},
                "in_main_job": False,
            },
            "benchmark.allow_short_split": True,
            "admissibility.runs": 1,
        }
    )
)


@pytest.fixture(scope="module")
def episodes(tmp_path_factory):
    """The released episodes of the split."""

    def make(root):
        root.mkdir()
        files = {name: root / f"{name}.jsonl" for name in ("scenes", "candidates", "trials", "admissible", "certified")}
        cache = Cache(root / "cache")
        homes = SETTINGS.splits["own"].homes
        scenes.run(scenes.draw_homes(homes), SETTINGS, files["scenes"], cache)
        candidates.run("own", files["scenes"], SETTINGS, files["candidates"])
        trials.run(files["scenes"], files["candidates"], SETTINGS, files["trials"], cache)
        verdict.run(files["trials"], SETTINGS, files["admissible"])
        certification.run(files["admissible"], files["trials"], SETTINGS, files["certified"], cache)
        given = files["trials"], files["admissible"], files["certified"]
        release.run(*given, SETTINGS, root / "episodes.jsonl", root / "sightings.jsonl", root / "rejections.csv", "own")

    return made_once(tmp_path_factory, "homes", make) / "episodes.jsonl"


def test_an_episode_of_a_home_is_evaluated_and_verified_from_its_file_alone(episodes, tours, tmp_path, capsys):
    (scene,) = {episode.scene for episode in Episode.load(episodes)}
    assert scene.startswith("Home-test-1-4.0-") and len(load_scene(scene)["rooms"]) == 1
    out = tmp_path / "out"
    assert command("eval", "--arm", DEPTH, "--episodes", episodes, "--seeds", 0, "--out", out, "--cache", tours) == 0
    assert command("verify", out, "--episodes", episodes) == 0
    assert "agree" in capsys.readouterr().out


def test_an_episode_of_another_home_is_refused_in_one_line(episodes, tours, tmp_path, capsys):
    """The digits at the end of the name are those of another house."""
    scene = Episode.load(episodes)[0].scene
    other = f"{scene[:-8]}{'0' * 8}"
    path = tmp_path / "other.jsonl"
    path.write_text(episodes.read_text().replace(scene, other))
    capsys.readouterr()
    assert command("eval", "--arm", DEPTH, "--episodes", path, "--seeds", 0, "--out", tmp_path / "out", "--cache", tours) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert other in line and scene[-8:] in line and "draw the split again" in line
