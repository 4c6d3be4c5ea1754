"""An agent in the LoCoBot's body, in the real engine: what it is given, how its body errs, what is measured where it stops."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from ovman.agents.interface import Action, Visit
from ovman.evaluation.assignment import assignment_of
from ovman.evaluation.rollout import Terms, execute
from ovman.evaluation.scores import cut, judge
from ovman.models.trial import Trial
from ovman.sim.embodiment import Embodiment
from ovman.sim.recorded import any_instance
from ovman.sim.session import Session
from ovman.workflow.parameter import StageSettings, canonical
from tests.arms import CONFIG, with_overlay

ROOT = Path(__file__).parents[3]
DATA = ROOT / "data" / "ovman-embedded-v1"
SCENE = "FloorPlan429"
CONSTANTS = StageSettings.parse(canonical(CONFIG, "executions", "cow"))
TASK = CONFIG.success


def read(path: Path) -> list[dict]:
    return [json.loads(line) for line in path.read_text().splitlines()]


EPISODES = {e["id"]: e for e in read(DATA / "episodes" / "main.jsonl")}
TRIALS = {t["candidate"]["id"]: t for t in read(DATA / "trials" / f"{SCENE}.jsonl") if t["candidate"]["id"] in EPISODES}


class Scripted:
    """Does what it is told, and keeps what it was given."""

    def __init__(self, *actions: Action, looks: bool = True) -> None:
        self.actions, self.given, self.visits, self.looks = list(actions), [], [], looks

    def familiarise(self, visit):
        self.visits.append(visit)

    def revisit(self, visit):
        self.visits.append(visit)

    def ask(self, query):
        self.query = query

    def act(self, observation):
        self.given.append(observation)
        return self.actions.pop(0) if self.actions else Action.STOP


@pytest.fixture(scope="module")
def session():
    with Session(SCENE, CONSTANTS, Embodiment.named("locobot", CONSTANTS)) as made:
        yield made


def executed(session, name, agent, noise=1, marks=()):
    nowhere = Visit((), np.empty((0, 2)))
    return execute(
        session,
        assignment_of(Trial.from_json(TRIALS[name])),
        agent,
        nowhere,
        lambda cells: Visit((), cells),
        None,
        np.random.default_rng(0),
        CONSTANTS,
        Terms(marks=marks, any_instance=True),
        noise,
    ).to_json()


SOME = next(iter(TRIALS))


def test_frames_are_its_own_and_nothing_else_is_told(session):
    agent = Scripted()
    executed(session, SOME, agent)
    (seen,) = agent.given
    side_px = CONSTANTS.locobot.side_px
    assert seen.rgb.shape == (side_px, side_px, 3) and seen.depth.shape == (side_px, side_px)
    assert seen.field_of_view_deg == CONSTANTS.locobot.field_of_view_deg
    assert seen.positions is None and seen.reachable is None
    assert all(not len(visit.reachable) for visit in agent.visits)
    assert seen.pose.y == pytest.approx(CONFIG.cow.camera_height_m, abs=CONFIG.cow.floor_tolerance_m / 2)


def test_its_body_errs_by_the_seed(session):
    moves = [Action.ROTATE_LEFT, Action.ROTATE_LEFT, Action.ROTATE_LEFT]
    one, again, other = (executed(session, SOME, Scripted(*moves), noise) for noise in (1, 1, 2))
    assert one == again and one["stop"]["yaw_deg"] != other["stop"]["yaw_deg"]
    asked = (TRIALS[SOME]["candidate"]["spawn"]["yaw_deg"] - 90.0) % 360.0
    off = abs((one["stop"]["yaw_deg"] - asked + 180.0) % 360.0 - 180.0)
    assert 0.0 < off < 5.0


def test_every_released_spawn_is_valid_for_its_body(session):
    for name in TRIALS:
        run = executed(session, name, Scripted())
        spawn = TRIALS[name]["candidate"]["spawn"]
        assert math.dist((run["stop"]["x"], run["stop"]["z"]), (spawn["x"], spawn["z"])) < 1e-3


def test_standing_still_ends_no_run(session):
    run = executed(session, SOME, Scripted(*[Action.ROTATE_LEFT] * 90, looks=False), marks=(40, 85))
    assert run["outcome"] == "stopped" and run["actions"] == 90 > CONSTANTS.primitives.stall_after
    assert run["path_at_m"] == {"40": 0.0, "85": 0.0}


def test_the_overlay_cuts_the_headline_from_the_longer_runs():
    arms = with_overlay("cow_500")
    assert arms["cow"].cut_from == "cow_500" and arms["cow_500"].budget is None
    assert (arms["cow"].agent, arms["cow"].embodiment) == (arms["cow_500"].agent, arms["cow_500"].embodiment)


def test_the_smaller_budget_is_the_same_run_cut(session):
    arm, record = with_overlay("cow_500")["cow"], {"schema": "ovman-run/1", "episode": SOME, "arm": "cow_500", "seed": 0}
    late = record | executed(session, SOME, Scripted(*[Action.ROTATE_LEFT] * 260, looks=False), marks=(arm.budget,))
    early = record | executed(session, SOME, Scripted(Action.ROTATE_LEFT), marks=(arm.budget,))
    assert cut(late, arm)["outcome"] == "budget" and cut(late, arm)["actions"] == arm.budget == 250
    assert not judge(cut(late, arm), EPISODES[SOME], TASK, own_task=True)["own_success"]
    assert cut(early, arm) == early | {"arm": "cow"}


def test_every_instance_that_is_there_is_measured_as_the_target_is(session):
    for name, trial in TRIALS.items():
        run = executed(session, name, Scripted())
        candidate = trial["candidate"]
        gone = {a["instance"] for a in candidate["second"] if a["kind"] == "disable"}
        there = {o["id"] for o in trial["measured"]["world_2"] if o["category"] == candidate["category"]} - gone
        assert there <= set(run["instances"]) and not gone & set(run["instances"])
        if run["visible_px"] is not None:
            assert run["instances"][candidate["target"]] == {k: run[k] for k in ("box_distance_m", "visible_px")}


def instance(box_distance_m, *px):
    return {"box_distance_m": box_distance_m, "visible_px": dict(zip(("0", "30", "60"), px, strict=True))}


def test_its_own_task_is_any_instance_that_is_near_and_seen():
    near, far, hidden = instance(0.9, 0, 120, 0), instance(1.1, 500, 500, 500), instance(0.2, 99, 0, 99)
    stopped = {"outcome": "stopped", "instances": {"a": far, "b": near}}
    assert any_instance(stopped, TASK)
    assert not any_instance(stopped | {"instances": {"a": far, "b": hidden}}, TASK)
    assert not any_instance(stopped | {"outcome": "budget"}, TASK)
    assert not any_instance(stopped | {"instances": {}}, TASK)
