"""The stage `dualmap`: from walks and episodes to the maps of every run; a map of nothing ends it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.dualmap import maps
from ovman.agents.dualmap.mapped import read
from ovman.agents.dualmap.observations import FrameObject, Shot, Taken, write_walks
from ovman.records.record import lines
from ovman.records.task import Relation
from ovman.records.visit import VisitPair
from ovman.settings.config import load
from tests.agents.dualmap.boxworld import DENSE, FEATURES, TEN, TOUR, walk
from tests.episodes import released

CONFIG = load(Path(__file__).parents[3] / "config.yaml")
SCENE = "FloorPlan1"
MOVED = [TEN[0].moved(1.0, 1.8), *TEN[1:]]
FRAMES = {"untouched": walk(TEN, DENSE, 1, 3), "displaced": walk(MOVED, DENSE, 2, 3), "glimpsed": walk(TEN, TOUR, 3, 3)}


def files(directory: Path, pairs: list[tuple[str, str]], visits: list[str]) -> SimpleNamespace:
    """Walks of these visits, and an episode for each pair."""
    shots, taken = [], {}
    for name in visits:
        numbers = range(len(shots), len(shots) + len(FRAMES[name]))
        shots += [
            Shot(tuple(FrameObject(o.class_id, o.feature, o.confidence, o.clouds) for o in seen), 2.5) for seen in FRAMES[name]
        ]
        taken[name] = Taken(np.array(numbers), np.zeros(len(numbers), int))
    paths = SimpleNamespace(**{name: directory / name for name in ("walks", "episodes", "output")})
    paths.walks.mkdir()
    write_walks(paths.walks / f"{SCENE}.npz", taken, shots, [f"class {k}" for k in range(FEATURES)])
    other = next(episode for episode in released() if episode.relation is Relation.MOVED)
    made = [
        other.model_copy(
            update={"id": f"{SCENE}/moved/{k:04}", "scene": SCENE, "visits": VisitPair[str](first=first, second=second)}
        )
        for k, (first, second) in enumerate(pairs)
    ]
    paths.episodes.write_text(lines(made))
    return paths


def run(paths: SimpleNamespace) -> None:
    maps.run(paths.episodes, paths.walks, CONFIG, paths.output)


def test_every_run_has_a_map_of_each_visit_and_of_each_pair_of_visits_that_was_released(tmp_path: Path):
    paths = files(tmp_path, [("untouched", "displaced")] * 2, ["untouched", "displaced"])
    run(paths)
    file = paths.output / f"{SCENE}.npz"
    first, runs = file.read_bytes(), read(file)
    assert len(runs) == CONFIG.dualmap.runs == 3
    for made in runs:
        assert {name: len(mapped.entries) for name, mapped in made.visits.items()} == {"untouched": 10, "displaced": 10}
        assert {pair: len(mapped.entries) for pair, mapped in made.maintained.items()} == {("untouched", "displaced"): 11}
    run(paths)
    assert file.read_bytes() == first


def test_a_map_of_nothing_ends_the_stage_with_the_scene_and_the_visit(tmp_path: Path):
    paths = files(tmp_path, [("untouched", "glimpsed")], ["untouched", "glimpsed"])
    with pytest.raises(maps.MapsError, match=r"^FloorPlan1: run 0: the map of glimpsed has no object after 24 keyframes"):
        run(paths)
    assert not list(paths.output.iterdir())


def test_an_episode_of_a_visit_that_was_not_walked_is_named(tmp_path: Path):
    paths = files(tmp_path, [("untouched", "displaced")], ["untouched"])
    with pytest.raises(maps.MapsError, match="no walk of the visit displaced; make the stage walks again"):
        run(paths)
