"""The stage `predictions` on released episodes, with maps that are true to what their tours recorded."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ovman.evaluation import predictions
from ovman.evaluation.supervision import AgentError
from ovman.perception.clusters import Cluster
from ovman.perception.labels import Labels, write_labels
from ovman.perception.records import write_maps, write_nouns
from ovman.records.prediction import Prediction
from ovman.records.record import lines
from ovman.task import recorded_world
from tests.episodes import DATA, SIGHTINGS, released, sightings
from tests.runs import job

SOME_SCENES = sorted({one.scene for one in released()})[::3]
CHOSEN = [one for one in released() if one.scene in SOME_SCENES]


@pytest.fixture
def predicted(tmp_path) -> Callable[..., None]:
    """Runs the stage for an arm."""
    (tmp_path / "episodes.jsonl").write_text(lines(CHOSEN))

    def run(arm: str, output: Path, maps: Path, nouns: Path, seen: Path | None = SIGHTINGS) -> None:
        files = {"maps": maps, "nouns": nouns, "labels": nouns.parent / "labels"}
        predictions.run(*job(arm), tmp_path / "episodes.jsonl", output, files, seen)

    return run


def handed_over(arm: str) -> dict[str, Prediction]:
    """The released answers of an arm that is given positions, by episode."""
    of = {p.episode: p for p in Prediction.read(DATA / "predictions" / "main" / f"{arm}.jsonl")}
    return {one.id: of[one.id] for one in CHOSEN}


@pytest.fixture(scope="module")
def perceived(tmp_path_factory) -> tuple[Path, Path]:
    """Maps with one cluster an instance, where it was last recorded, with a feature for each category; and the nouns.

    Beside the nouns lie labels that say of each detection what it shows.
    """
    directory = tmp_path_factory.mktemp("perceived")
    nouns = {episode.category: episode.noun for episode in CHOSEN}
    feature = dict(zip(sorted(nouns), np.eye(len(nouns)), strict=True))
    scenes: dict[str, dict[str, dict[str, Cluster]]] = {}
    for episode in CHOSEN:
        for which in ("first", "second"):
            found = scenes.setdefault(episode.scene, {}).setdefault(episode.visits[which], {})
            for k in recorded_world(sightings()[episode.id].sightings[which], episode.category, 300):
                place, track = np.array(k.position), np.array(k.track)
                found[k.id] = Cluster(place, feature[episode.category], track, np.arange(len(track)))
    for name in ("maps", "labels"):
        (directory / name).mkdir()
    categories = tuple(sorted(nouns))
    for scene, visits in scenes.items():
        numbered, labels = {}, {}
        for name, found in visits.items():
            ends = np.cumsum([len(one.track) for one in found.values()])
            numbered[name] = [
                replace(one, members=np.arange(end - len(one.track), end)) for one, end in zip(found.values(), ends, strict=True)
            ]
            shown = np.concatenate([np.zeros(0, int), *(np.full(len(one.track), one.feature.argmax()) for one in found.values())])
            labels[name] = Labels(categories, shown, np.full(len(shown), 500))
        write_maps(directory / "maps" / f"{scene}.npz", numbered)
        write_labels(directory / "labels" / f"{scene}.npz", labels)
    write_nouns(directory / "nouns.npz", {nouns[category]: vector for category, vector in feature.items()})
    return directory / "maps", directory / "nouns.npz"


@pytest.mark.parametrize("arm", ["two_visits", *(f"grounding_two_visits{reading}" for reading in ("", "_any", "_nearest"))])
def test_true_maps_lead_to_the_answers_of_positions_handed_over(predicted, perceived, tmp_path, arm):
    predicted(arm, tmp_path / "out.jsonl", *perceived)
    handed = handed_over("positions_two_visits")
    found = Prediction.read(tmp_path / "out.jsonl")
    assert [p.episode for p in found] == list(handed)
    # MOVING is decided by another rule where perception is the agent's own.
    still = [p for p in found if "/moving/" not in p.episode]
    assert len(still) > 50
    for p in still:
        assert p.outcome == handed[p.episode].outcome, p.episode
        assert p.arm == arm and p.evidence is not None and p.evidence.grounded_1 is not None


@pytest.mark.parametrize("arm", ["single_visit", "grounding_single_visit"])
def test_true_maps_leave_a_single_visit_what_positions_handed_over_leave_it(predicted, perceived, tmp_path, arm):
    predicted(arm, tmp_path / "out.jsonl", *perceived)
    handed = handed_over("positions_single_visit")
    for p in Prediction.read(tmp_path / "out.jsonl"):
        assert p.outcome == handed[p.episode].outcome, p.episode


def test_a_scene_without_maps_and_a_visit_without_a_map_are_named(predicted, perceived, tmp_path):
    maps, nouns = shutil.copytree(perceived[0], tmp_path / "maps"), perceived[1]
    first = min(maps.iterdir())
    write_maps(first, {"elsewhere": ()})
    with pytest.raises(AgentError, match="make the stage maps again"):
        predicted("two_visits", tmp_path / "out.jsonl", maps, nouns)
    first.unlink()
    with pytest.raises(AgentError, match=f"needs maps, and {first.stem} has none; make them"):
        predicted("two_visits", tmp_path / "out.jsonl", maps, nouns)


@pytest.mark.parametrize("arm", ["positions_two_visits", "grounding_two_visits_nearest"])
def test_only_an_arm_that_is_given_the_truth_opens_the_sightings(predicted, perceived, tmp_path, arm):
    with pytest.raises(ValueError, match=f"arms.{arm} is given its grounding or positions: it needs the file of sightings"):
        predicted(arm, tmp_path / "out.jsonl", *perceived, seen=None)
    for other in ("two_visits", "grounding_two_visits"):
        predicted(other, tmp_path / "out.jsonl", *perceived, seen=tmp_path / "there is no such file")


def test_only_an_arm_whose_grounding_is_handed_over_by_its_detections_is_given_what_they_show(predicted, perceived, tmp_path):
    (tmp_path / "labels").mkdir()
    nouns = Path(shutil.copy(perceived[1], tmp_path / "nouns.npz"))
    for arm in ("two_visits", "grounding_two_visits_nearest"):
        predicted(arm, tmp_path / "out.jsonl", perceived[0], nouns)
    for arm in ("grounding_two_visits", "grounding_two_visits_any"):
        with pytest.raises(AgentError, match=f"arms.{arm} is given its grounding: it needs the labels of FloorPlan"):
            predicted(arm, tmp_path / "out.jsonl", perceived[0], nouns)
