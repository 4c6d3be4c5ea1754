"""The pure stages of the generation bring the released data about again, byte for byte."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from ovman import seeds
from ovman.generation import candidates, release, verdict
from ovman.generation.candidates import Subject
from ovman.generation.distractors import Surroundings
from ovman.generation.drawing import drawings
from ovman.records.record import lines
from ovman.records.scene import Scene
from ovman.records.task import Relation
from ovman.records.trial import Candidate, Certification, Trial, Verdict
from ovman.shipped import HOME
from tests.arms import CONFIG
from tests.episodes import DATA

KINDS = {"scenes": ".json", "trials": ".jsonl", "certified": ".jsonl"}
SCENES = sorted(file.stem for file in (DATA / "trials").iterdir())
SOME = [scene if scene in ("FloorPlan1", "FloorPlan330") else pytest.param(scene, marks=pytest.mark.soak) for scene in SCENES]


@pytest.mark.parametrize("scene", SOME)
def test_a_scene_gives_its_candidates(scene: str, tmp_path: Path) -> None:
    drawn = tmp_path / "candidates.jsonl"
    candidates.run(DATA / "scenes" / f"{scene}.json", CONFIG, drawn)
    released = [trial.candidate for trial in Trial.read(DATA / "trials" / f"{scene}.jsonl")]
    splits = {candidate.split for candidate in released}
    assert lines(candidate for candidate in Candidate.read(drawn) if candidate.split in splits) == lines(released)
    assert len(released) > 0


def test_the_threshold_that_the_docs_change_changes_no_episode() -> None:
    """Else what they call half a minute has tours recorded and agents driven again."""
    page = (HOME / "docs" / "workflow.md").read_text()
    found = re.search(r"drift_tolerance_m: ([\d.]+)/drift_tolerance_m: ([\d.]+)/", page)
    assert found and float(found[1]) == CONFIG.admissibility.drift_tolerance_m
    certified = {one.id for scene in SCENES for one in Certification.read(DATA / "certified" / f"{scene}.jsonl")}
    trials = [one for scene in SCENES for one in Trial.read(DATA / "trials" / f"{scene}.jsonl") if one.candidate.id in certified]
    drifts_m = [drift_m for one in trials for drift_m in (one.measured.drift_m or {}).values()]
    assert float(found[1]) > float(found[2]) >= max(drifts_m) > 0


@pytest.mark.parametrize("number", (0, 1, 2, 6, 9))
def test_a_mover_with_distractors_goes_as_far_as_the_movers_of_its_tour(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """In this scene a mover is near the least that it has to go: the walk of another tour would decide otherwise.

    Several candidates, because one walk may decide as another does. So may all five: their streams are compared, too.
    """
    (scene,) = Scene.read(DATA / "scenes" / "FloorPlan224.json")
    drawing = next(one for one in drawings(scene, CONFIG) if one.split == "everyday")
    assert drawing.others is not None
    surroundings = Surroundings(scene, drawing.tours, drawing.others, CONFIG)
    name = drawing.id(scene.scene, Relation.MOVING.value, number)
    trials = Trial.read(DATA / "trials" / f"{scene.scene}.jsonl")
    released = next(trial.candidate for trial in trials if trial.candidate.id == name)
    target = next(item for item in scene.objects if item.id == released.target)
    drawn, walks = candidates.draw_distractors, []

    def watched(*arguments: Any) -> Any:
        walks.append(arguments[-1].bit_generator.state)
        return drawn(*arguments)

    monkeypatch.setattr(candidates, "draw_distractors", watched)
    assert (
        candidates.draw_candidate(scene, Subject(Relation.MOVING, target, None), number, drawing, CONFIG, surroundings)
        == released
    )
    assert walks == [seeds.generator(CONFIG.benchmark.seed, *seeds.tour_movers(name)).bit_generator.state]


@pytest.mark.parametrize("scene", SOME)
def test_the_admissible_trials_are_those_that_were_certified(scene: str, tmp_path: Path) -> None:
    verdicts = tmp_path / "admissible.jsonl"
    verdict.run(DATA / "trials" / f"{scene}.jsonl", CONFIG, verdicts)
    admitted = [v.id for v in Verdict.read(verdicts) if v.rejected is None]
    assert admitted == [certified.id for certified in Certification.read(DATA / "certified" / f"{scene}.jsonl")]


def test_trials_and_certifications_give_the_episodes_their_sightings_and_the_audit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {kind: [DATA / kind / f"{scene}{end}" for scene in SCENES] for kind, end in KINDS.items()}
    admissible = [tmp_path / f"{scene}.jsonl" for scene in SCENES]
    for trials, verdicts in zip(files["trials"], admissible, strict=True):
        verdict.run(trials, CONFIG, verdicts)
    made = [tmp_path / name for name in ("main.jsonl", "sightings.jsonl", "rejections.csv")]
    capsys.readouterr()
    release.run(files["trials"], admissible, files["certified"], CONFIG, *made)
    expected = (DATA / "episodes/main.jsonl", DATA / "episodes/sightings.jsonl", DATA / "metrics/rejections.csv")
    assert [file.read_bytes() for file in made] == [file.read_bytes() for file in expected]
    said = capsys.readouterr().out.splitlines()
    assert "main, moved: 33 released of 51 certified and independent, 33 wanted" in said and len(said) == 6
