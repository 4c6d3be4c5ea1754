"""An episode in which more than the scripted change differs, through the real engine: measured, recorded, run from its record."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ovman.evaluation.tours import record_tour
from ovman.generation.candidates import draw_candidates
from ovman.generation.certification import oracle_run
from ovman.generation.drawing import Drawing
from ovman.generation.release import episode
from ovman.generation.trials import Trials
from ovman.records.episode import Episode
from ovman.records.task import Relation
from ovman.records.trial import Trial
from ovman.records.visit import Visit, VisitFiles
from ovman.runner import open_session
from ovman.settings.jobs import settings_of_arm
from ovman.sim.session import Session
from tests.arms import CONFIG
from tests.generation.test_others import CONSTANTS, drawing, scene_of

SCENE = "FloorPlan7"
ASKED = (Relation.MOVING, Relation.APPEARED)


@cache
def few() -> Drawing:
    """A drawing of the split that asks for few candidates of two relations."""
    every = drawing(scene_of(SCENE))
    draws = every.split.draws.model_copy(update={one.value: 4 * (one in ASKED) for one in Relation})
    return Drawing(every.split.model_copy(update={"draws": draws, "light": None}), every.tours)


@pytest.fixture(scope="module")
def measured(tmp_path_factory) -> tuple[Path, dict[Relation, Trial]]:
    """The first trial of each relation that came to its end, and where its tours are."""
    directory, scene = tmp_path_factory.mktemp("visits"), scene_of(SCENE)
    settings, found = CONFIG, {}
    drawn = [c for c in draw_candidates(scene, few(), CONSTANTS) if c.refused is None]
    with Session(SCENE, settings) as session:
        trials = Trials(session, scene, settings, directory, "code")
        for candidate in drawn:
            if candidate.relation not in found:
                trial = trials.measure(candidate)
                if trial.measured.ended is None and trial.measured.visits is not None:
                    found[candidate.relation] = trial
    assert {*found} == {*ASKED}
    return directory, found


def episode_of(trial: Trial) -> Episode:
    return Episode.from_json(episode(trial, (), CONFIG).to_json())


@pytest.mark.parametrize("relation", [Relation.MOVING, pytest.param(Relation.APPEARED, marks=pytest.mark.soak)])
def test_the_record_alone_gives_the_tours_that_were_measured_to_the_byte(measured, tmp_path, relation):
    directory, found = measured
    one, settings = episode_of(found[relation]), settings_of_arm(CONFIG, "oracle_check")
    assert one.tours.first != one.tours.second and not {*one.tours.first.poses} & {*one.tours.second.poses}
    with open_session(one, CONFIG.arms["oracle_check"], settings) as session:
        for which in ("first", "second"):
            made = record_tour(session, one, which, tmp_path, CONFIG.measurement.min_mask_px)
            was = Visit.load(directory / one.visits[which])
            assert made == was
            files = [VisitFiles.load(place / one.visits[which]) for place in (directory, tmp_path)]
            assert files[0].sha256 == files[1].sha256
            assert [(v.pose.x, v.pose.z, v.pose.yaw_deg) for v in made.views] == [
                (p.x, p.z, p.yaw_deg) for p in one.tours[which].poses
            ]
    assert tuple(mover.start for mover in made.movers) == one.movers


def test_several_movers_walk_each_on_a_floor_of_its_own(measured):
    one = episode_of(measured[1][Relation.MOVING])
    walks = {change.instance: change for change in one.changes if change.kind == "motion"}
    assert len(walks) >= 2 and {mover.instance for mover in one.movers} == {*walks}
    for change in walks.values():
        assert {change.roam.cell(point) for point in change.path} <= change.roam.cells
        assert len({*change.path}) > 1 and len(change.path) == len(one.tours.second.poses) + 1
    paths = [np.array(change.path) for change in walks.values()]
    assert np.hypot(*(paths[0] - paths[1]).T).min() >= CONFIG.candidates.apart_m - 1e-3


def test_the_oracle_follows_the_target_among_several_movers(measured):
    trial, settings = measured[1][Relation.MOVING], CONFIG
    with Session(SCENE, settings) as session:
        runs = [oracle_run(session, trial, 7, settings) for _ in range(2)]
    assert runs[0] == runs[1] and runs[0].outcome == "stopped"
    assert runs[0].box_distance_m is not None and runs[0].box_distance_m <= CONFIG.success.radius_m
