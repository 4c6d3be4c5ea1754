"""An agent in the LoCoBot's body, in the real engine: what it is given, how its body errs, what is measured where it stops."""

from __future__ import annotations

import math

import pytest

from ovman.agents.interface import Action
from ovman.evaluation.context import run_settings
from ovman.evaluation.scores import cut_rollout, is_at_any_instance, score_rollout
from ovman.records.run import InstanceTerms, Measured, Rollout
from ovman.runner import open_session
from tests.arms import CONFIG, with_overlay
from tests.episodes import of_scene
from tests.runs import Quiet, job, run_agent

SCENE = "FloorPlan429"
ARM, SETTINGS = job("cow")
TASK = CONFIG.success
EPISODES = {episode.id: episode for episode in of_scene(SCENE)}


class Scripted(Quiet):
    """Does what it is told, and keeps what it was given."""

    def __init__(self, *actions: Action, looks: bool = True) -> None:
        self.actions, self.given, self.visits, self.looks = list(actions), [], [], looks

    def familiarise(self, visit):
        self.visits.append(visit)

    revisit = familiarise

    def act(self, observation):
        self.given.append(observation)
        return self.actions.pop(0) if self.actions else Action.STOP


@pytest.fixture(scope="module")
def session():
    with open_session(EPISODES[SOME], ARM, SETTINGS) as made:
        yield made


def executed(session, name, agent, noise=1, marks=()) -> Measured:
    settings = run_settings(EPISODES[name], SETTINGS)
    return run_agent(session, EPISODES[name], agent, settings, actuation_seed=noise, marks=marks, any_instance=True)


SOME = next(iter(EPISODES))


def test_frames_are_its_own_and_nothing_else_is_told(session):
    agent = Scripted()
    executed(session, SOME, agent)
    (seen,) = agent.given
    side_px = SETTINGS.locobot.side_px
    assert seen.rgb.shape == (side_px, side_px, 3) and seen.depth.shape == (side_px, side_px)
    assert seen.field_of_view_deg == SETTINGS.locobot.field_of_view_deg
    assert seen.positions is None and seen.reachable is None
    assert all(not len(visit.reachable) for visit in agent.visits)
    assert seen.pose.y == pytest.approx(CONFIG.cow.camera_height_m, abs=CONFIG.cow.floor_tolerance_m / 2)


def test_its_body_errs_by_the_seed(session):
    moves = [Action.ROTATE_LEFT, Action.ROTATE_LEFT, Action.ROTATE_LEFT]
    one, again, other = (executed(session, SOME, Scripted(*moves), noise) for noise in (1, 1, 2))
    assert one == again and one.stop.yaw_deg != other.stop.yaw_deg
    asked = (EPISODES[SOME].spawn.yaw_deg - 90.0) % 360.0
    off = abs((one.stop.yaw_deg - asked + 180.0) % 360.0 - 180.0)
    assert 0.0 < off < 5.0


def test_every_released_spawn_is_valid_for_its_body(session):
    for name, episode in EPISODES.items():
        run = executed(session, name, Scripted())
        assert math.dist((run.stop.x, run.stop.z), (episode.spawn.x, episode.spawn.z)) < 1e-3


def test_standing_still_ends_no_run(session):
    run = executed(session, SOME, Scripted(*[Action.ROTATE_LEFT] * 90, looks=False), marks=(40, 85))
    assert run.outcome == "stopped" and run.actions == 90 > CONFIG.primitives.stall_after
    assert run.path_at_m == {40: 0.0, 85: 0.0}


def test_the_overlay_cuts_the_headline_from_the_longer_runs():
    arms = with_overlay("cow_500")
    assert arms["cow"].cut_from == "cow_500" and arms["cow_500"].budget is None
    assert (arms["cow"].agent, arms["cow"].embodiment) == (arms["cow_500"].agent, arms["cow_500"].embodiment)


def test_the_smaller_budget_is_the_same_run_cut(session):
    arm = with_overlay("cow_500")["cow"]

    def run(agent: Scripted) -> Rollout:
        return Rollout(episode=SOME, arm="cow_500", seed=0, **dict(executed(session, SOME, agent, marks=(arm.budget,))))

    late = run(Scripted(*[Action.ROTATE_LEFT] * 260, looks=False))
    early = run(Scripted(Action.ROTATE_LEFT))
    assert cut_rollout(late, arm).outcome == "budget" and cut_rollout(late, arm).actions == arm.budget == 250
    assert score_rollout(cut_rollout(late, arm), EPISODES[SOME], any_instance=True).own_success is False
    assert cut_rollout(early, arm) == early.model_copy(update={"arm": "cow"})


def test_every_instance_that_is_there_is_measured_as_the_target_is(session):
    for name, episode in EPISODES.items():
        run = executed(session, name, Scripted())
        there = {o.id for o in episode.world_2 if o.category == episode.category} - episode.gone
        assert there <= set(run.instances) and not episode.gone & set(run.instances)
        if run.visible_px is not None:
            terms = InstanceTerms(box_distance_m=run.box_distance_m, visible_px=run.visible_px)
            assert run.instances[episode.target] == terms


def instance(box_distance_m, *px):
    return InstanceTerms(box_distance_m=box_distance_m, visible_px=dict(zip((0, 30, 60), px, strict=True)))


def test_its_own_task_is_any_instance_that_is_near_and_seen(session):
    near, far, hidden = instance(0.9, 0, 120, 0), instance(1.1, 500, 500, 500), instance(0.2, 99, 0, 99)
    run = executed(session, SOME, Scripted())

    def reached(outcome="stopped", **instances):
        return is_at_any_instance(run.model_copy(update={"outcome": outcome, "instances": instances}), TASK)

    assert reached(a=far, b=near)
    assert not reached(a=far, b=hidden)
    assert not reached(outcome="budget", a=far, b=near)
    assert not reached()
