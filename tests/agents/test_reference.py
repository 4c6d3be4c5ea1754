"""The reference agent: on wheels in the real engine, with maps that are true to what was recorded."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ovman.agents.interface import Action, Agent, Visit
from ovman.agents.reference.agent import ReferenceAgent, SingleVisitAgent
from ovman.agents.reference.mapper import KeptMaps
from ovman.agents.reference.reasoning import ReferenceConstants
from ovman.evaluation import rollouts as executions
from ovman.evaluation import scores as runs
from ovman.evaluation.assignment import assignment_of
from ovman.evaluation.observation_store import Senses
from ovman.evaluation.perceived import Perceived
from ovman.evaluation.privileged_grounding import recorded_positions
from ovman.evaluation.rollout import execute
from ovman.language import noun
from ovman.models.settings.arms import ArmJob
from ovman.models.trial import Trial
from ovman.perception.clusters import Cluster
from ovman.perception.records import write_maps, write_nouns
from ovman.sim.recorded import judged
from ovman.sim.session import Session
from ovman.task import Query, Relation
from ovman.workflow.parameter import StageSettings, canonical, stage_settings
from tests.arms import CONFIG

ROOT = Path(__file__).parents[2]
DATA = ROOT / "data" / "ovman-embedded-v1"
SCENE = "FloorPlan429"
TWO_VISITS = stage_settings(CONFIG, "executions", "two_visits_embodied").arm


def with_fields(arm: ArmJob, **fields: Any) -> ArmJob:
    return arm.model_copy(update=fields)


def constants(overrides: dict | None = None, arm: str = "two_visits_embodied") -> StageSettings:
    text = json.loads(canonical(CONFIG, "executions", arm))
    return StageSettings.parse(json.dumps(text | {"constants": text["constants"] | (overrides or {})}))


def read(path: Path) -> list[dict]:
    return [json.loads(line) for line in path.read_text().splitlines()]


RELEASED = {e["id"] for e in read(DATA / "episodes" / "main.jsonl")}
TRIALS = [t for t in read(DATA / "trials" / f"{SCENE}.jsonl") if t["candidate"]["id"] in RELEASED]


def trial(relation: Relation) -> dict:
    return next(t for t in TRIALS if t["candidate"]["relation"] == relation)


def true_map(sightings, category: str) -> tuple[Cluster, ...]:
    """One cluster for each place where an instance was recorded, and something else far away."""
    places = np.unique(recorded_positions(sightings, 300), axis=0)
    feature, other = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    views = np.array([0])
    return (
        *(Cluster(place, feature, place[None], views) for place in places),
        Cluster(np.array([50.0, 50.0]), other, np.array([[50.0, 50.0]]), views),
    )


@dataclass
class TrueEyes:
    """Eyes to which a tour is its visit's name."""

    trial: dict

    def __post_init__(self) -> None:
        measured, category = self.trial["measured"], self.trial["candidate"]["category"]
        maps = {measured["visits"][v]: true_map(measured["sightings"][v], category) for v in ("first", "second")}
        self.perceived = Perceived(maps, {noun(category): np.array([1.0, 0.0])})
        self.mapper, self.noun = KeptMaps(maps), self.perceived.noun

    def visit(self, name, reachable):
        return Visit((), reachable, name)


@pytest.fixture(scope="module")
def session():
    with Session(SCENE, constants()) as made:
        yield made


@pytest.mark.parametrize("relation", sorted({t["candidate"]["relation"] for t in TRIALS} - {"moving"}))
def test_with_true_maps_it_gets_there_and_draws_nothing(session, monkeypatch, relation):
    drawn = []
    step = Session.step

    def watched(self, action, image=False, **arguments):
        drawn.append((action, image))
        return step(self, action, image=image, **arguments)

    monkeypatch.setattr(Session, "step", watched)
    chosen = trial(Relation(relation))
    run = executions.execution(session, TWO_VISITS, 0, chosen, constants(), TrueEyes(chosen))
    assert run["outcome"] == "stopped" and run["arm"] == "two_visits_embodied"
    assert judged(run, Relation(relation), constants({"success.radius_m": 1.0, "success.visible_px": 100}).success)
    # Frames are drawn for the look-down sweep at the stop alone.
    assert {action for action, image in drawn if image} <= {"TeleportFull"}
    assert executions.execution(session, TWO_VISITS, 0, chosen, constants(), TrueEyes(chosen)) == run


def test_the_single_visit_draws_by_its_seed(session):
    chosen = trial(Relation.FORMER)
    arm, eyes = stage_settings(CONFIG, "executions", "single_visit_embodied").arm, TrueEyes(chosen)
    one, again, other = (executions.execution(session, arm, seed, chosen, constants(), eyes) for seed in (0, 0, 1))
    assert one == again and one["stop"] != other["stop"]


@pytest.mark.parametrize("budget", [4, 7, 300])
def test_a_run_that_is_cut_is_the_run_under_that_budget(session, budget):
    chosen, eyes = trial(Relation.FORMER), TrueEyes(trial(Relation.FORMER))
    whole = executions.execution(session, with_fields(TWO_VISITS, marks=(budget,)), 0, chosen, constants(), eyes)
    assert whole["outcome"] == "stopped" and 7 < whole["actions"] < 300
    short = executions.execution(session, with_fields(TWO_VISITS, budget=budget), 0, chosen, constants(), eyes)
    cut = runs.cut(whole, with_fields(TWO_VISITS, name="short", cut_from="two_visits_embodied", budget=budget))
    assert {key: cut[key] for key in short} == short | {"arm": "short"}
    assert runs.cut(whole, TWO_VISITS) is whole


def test_a_run_that_left_no_mark_cannot_be_cut():
    whole = {"episode": "e", "arm": "long", "outcome": "stopped", "actions": 9}
    with pytest.raises(ValueError, match="e: long was not run for short; make its executions again"):
        runs.cut(whole, with_fields(TWO_VISITS, name="short", cut_from="long", budget=9))
    for actions, outcome in ((8, "stopped"), (9, "stalled"), (9, "budget")):
        ended = whole | {"actions": actions, "outcome": outcome}
        assert runs.cut(ended, with_fields(TWO_VISITS, name="short", cut_from="long", budget=9)) == ended | {"arm": "short"}


class Watcher:
    """Looks at whatever it is given, and stops."""

    def __init__(self, says: bool | None) -> None:
        self.frames = []
        if says is not None:
            self.looks = says

    def familiarise(self, visit):
        pass

    def revisit(self, visit):
        pass

    def ask(self, query):
        pass

    def act(self, observation):
        self.frames.append(observation)
        return Action.STOP


@pytest.mark.parametrize(("says", "looks"), [(None, True), (True, True), (False, False)])
def test_frames_are_drawn_unless_an_agent_says_that_it_does_not_look(session, says, looks):
    agent = Watcher(says)
    assert isinstance(agent, Agent)
    nowhere = Visit((), np.empty((0, 2)))
    execute(
        session,
        assignment_of(Trial.from_json(TRIALS[0])),
        agent,
        nowhere,
        lambda cells: nowhere,
        None,
        np.random.default_rng(0),
        constants(),
    )
    (frame,) = agent.frames
    assert frame.positions is None and (frame.rgb is not None) == (frame.depth is not None) == looks


class Wheels:
    """A pilot that is nowhere and says where it is sent."""

    def __init__(self) -> None:
        self.goals = []

    def set_out(self, reachable, relation):
        self.reachable = reachable

    def act(self, observation, goal):
        self.goals.append(goal)
        return Action.STOP


def agents():
    eyes = TrueEyes(TRIALS[0])
    maps = {"empty": (), **eyes.perceived.maps}
    given = (KeptMaps(maps), eyes.perceived.noun, ReferenceConstants.of(constants()))
    wheels = Wheels()
    return wheels, (ReferenceAgent(wheels, *given), SingleVisitAgent(wheels, *given, np.random.default_rng(0)))


def asked(agent, first: str, second: str, relation: Relation) -> Action:
    agent.familiarise(Visit((), np.empty((0, 2)), first))
    agent.revisit(Visit((), np.array([[0.0, 0.0], [1.0, 1.0]]), second))
    agent.ask(Query(TRIALS[0]["candidate"]["category"], relation))
    return agent.act(None)


def test_they_are_agents_that_forget_and_abstain():
    wheels, both = agents()
    visits = TRIALS[0]["measured"]["visits"]
    for agent in both:
        assert isinstance(agent, Agent) and agent.looks is False
        assert asked(agent, visits["first"], visits["second"], Relation.STABLE) is Action.STOP
        assert asked(agent, "empty", "empty", Relation.STABLE) is Action.ABSTAIN
    assert len(wheels.goals) == 2 and all(len(goal) == 2 for goal in wheels.goals)


def test_a_tour_without_a_map_and_a_noun_without_an_embedding_are_named():
    _, both = agents()
    with pytest.raises(ValueError, match="make the stage maps again"):
        both[0].familiarise(Visit((), np.empty((0, 2)), "elsewhere"))
    with pytest.raises(ValueError, match="make the stage maps again"):
        both[0].familiarise(Visit((), np.empty((0, 2))))
    both[1].revisit(Visit((), np.empty((0, 2)), "empty"))
    with pytest.raises(ValueError, match="'sofa'.* make the stage nouns again"):
        both[1].ask(Query("Sofa", Relation.MOVED))


def test_a_threshold_that_changes_no_answer_is_no_new_run():
    chosen = TRIALS[0]
    eyes = TrueEyes(chosen)

    def key(constants, seed=0, eyes=eyes):
        return executions.unit(TWO_VISITS, seed, chosen, constants, eyes)

    usual = key(constants())
    assert key(constants({"association.gate_m": 1.2501, "grounding.similarity_margin": 0.031})) == usual
    assert key(constants({"primitives.stop_within_m": 0.61})) != usual
    assert key(constants(), seed=1) != usual
    blind = TrueEyes(chosen)
    blind.perceived = Perceived(dict.fromkeys(eyes.perceived.maps, ()), eyes.perceived.nouns)
    assert key(constants(), eyes=blind) != usual


def test_an_arm_that_executes_nobodys_answer_is_run_again_when_what_it_sees_or_reads_changes(tmp_path):
    chosen = TRIALS[0]
    arm = with_fields(TWO_VISITS, executes=None)
    files = {"maps": tmp_path / f"{SCENE}.npz", "nouns": tmp_path / "nouns.npz"}
    eyes = TrueEyes(chosen)

    def key(overrides=None, seed=0):
        stage = json.loads(constants(overrides).canonical)
        del stage["arm"]["executed"]
        text = StageSettings.parse(json.dumps(stage))
        return executions.unit(arm, seed, chosen, text, Senses(arm, text, tmp_path, files))

    write_nouns(files["nouns"], eyes.perceived.nouns)
    write_maps(files["maps"], eyes.perceived.maps)
    usual = key()
    assert key() == usual != key(seed=1)
    assert key({"association.gate_m": 1.2501}) != usual
    write_maps(files["maps"], dict.fromkeys(eyes.perceived.maps, ()))
    assert key() != usual
