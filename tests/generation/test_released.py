"""The pure stages of the generation bring the released data about again, byte for byte."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from ovman import seeds
from ovman.generation import candidates, release, verdict
from ovman.generation.distractors import Surroundings
from ovman.generation.drawing import Drawing
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.scene import Scene
from ovman.records.task import Relation
from ovman.records.trial import Certification, Trial, Verdict
from tests.arms import CONFIG
from tests.episodes import DATA, scene_record

SPLITS = sorted(file.stem for file in (DATA / "trials").iterdir())
SCENES = ("FloorPlan1", "FloorPlan330", "FloorPlan6")


@pytest.mark.parametrize("split", SPLITS)
def test_scenes_give_their_candidates(split: str, tmp_path: Path) -> None:
    scenes, drawn = tmp_path / "scenes.jsonl", tmp_path / "candidates.jsonl"
    scenes.write_text(lines(one for one in Scene.read(DATA / "scenes" / f"{split}.jsonl") if one.scene in SCENES))
    candidates.run(split, scenes, CONFIG, drawn)
    trials = Trial.read(DATA / "trials" / f"{split}.jsonl")
    released = [trial.candidate for trial in trials if trial.candidate.scene in SCENES]
    assert drawn.read_text() == lines(released) and released


@pytest.mark.parametrize("number", (0, 1, 2, 6, 9))
def test_a_mover_with_distractors_goes_as_far_as_the_movers_of_its_tour(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """In this scene a mover is near the least that it has to go: the walk of another tour would decide otherwise.

    Several candidates, because one walk may decide as another does. So may all five: their streams are compared, too.
    """
    scene = scene_record("FloorPlan224")
    drawing = Drawing.of(CONFIG.splits["everyday"], scene, CONFIG)
    assert drawing.split.others is not None
    surroundings = Surroundings(scene, drawing.tours, drawing.split.others, CONFIG)
    name = drawing.id(scene.scene, Relation.MOVING.value, number)
    trials = Trial.read(DATA / "trials" / "everyday.jsonl")
    released = next(trial.candidate for trial in trials if trial.candidate.id == name)
    target = next(item for item in scene.objects if item.id == released.target)
    drawn, walks = candidates.draw_distractors, []

    def watched(*arguments: Any) -> Any:
        walks.append(arguments[-1].bit_generator.state)
        return drawn(*arguments)

    monkeypatch.setattr(candidates, "draw_distractors", watched)
    about = scene, Relation.MOVING, target, None, number
    assert candidates.draw_candidate(*about, drawing, CONFIG, surroundings) == released
    assert walks == [seeds.generator(CONFIG.benchmark.seed, *seeds.tour_movers(name)).bit_generator.state]


@pytest.mark.parametrize("split", SPLITS)
def test_trials_and_certifications_give_the_episodes_their_sightings_and_the_audit(split: str, tmp_path: Path) -> None:
    trials, certified = (DATA / stage / f"{split}.jsonl" for stage in ("trials", "certified"))
    verdict.run(trials, CONFIG, tmp_path / "admissible.jsonl")
    admitted = [one.id for one in Verdict.read(tmp_path / "admissible.jsonl") if one.rejected is None]
    assert admitted == [one.id for one in Certification.read(certified)]
    made = [tmp_path / name for name in ("episodes.jsonl", "sightings.jsonl", "rejections.csv")]
    release.run(trials, tmp_path / "admissible.jsonl", certified, CONFIG, *made, split)
    expected = (f"episodes/{split}.jsonl", f"sightings/{split}.jsonl", f"metrics/{split}/rejections.csv")
    assert [file.read_bytes() for file in made] == [(DATA / name).read_bytes() for name in expected]


def test_several_movers_walk_each_on_a_floor_of_its_own() -> None:
    together = [one for one in Episode.load(DATA / "episodes" / "everyday.jsonl") if len(one.movers) > 1]
    assert together
    for one in together:
        walks = [change for change in one.changes if change.kind == "motion"]
        assert {mover.instance for mover in one.movers} == {change.instance for change in walks}
        for change in walks:
            assert change.roam is not None and change.path is not None
            assert {change.roam.cell(point) for point in change.path} <= change.roam.cells
            assert len({*change.path}) > 1 and len(change.path) == len(one.tours.second.poses) + 1
