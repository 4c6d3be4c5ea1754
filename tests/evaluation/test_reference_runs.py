"""Runs of the reference agent in the engine, with maps that are true to the recorded tours, and what their cache keys hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from ovman.agents.interface import Action, Agent, Relation, Visit
from ovman.evaluation import scores
from ovman.evaluation.observations import ObservationStore, Perceived
from ovman.evaluation.rollouts import rollout_key
from ovman.evaluation.scores import is_success
from ovman.perception.records import write_maps, write_nouns
from ovman.records.episode import Episode
from ovman.records.run import NOWHERE, Rollout
from ovman.runner import Run, open_session, run_episode
from ovman.settings import Settings
from ovman.settings.arms import ArmJob
from ovman.sim.session import Session
from tests.episodes import of_scene, sightings, true_map
from tests.runs import Quiet, job, run_agent

SCENE = "FloorPlan429"
EPISODES = of_scene(SCENE)
TWO_VISITS = job("two_visits_embodied")[0]


def with_fields(arm: ArmJob, **fields: Any) -> ArmJob:
    return arm.model_copy(update=fields)


def settings(overrides: dict | None = None, arm: str = "two_visits_embodied") -> Settings:
    return job(arm)[1].with_values(overrides or {})


def of(relation: Relation) -> Episode:
    return next(episode for episode in EPISODES if episode.relation is relation)


def with_protocol(episode: Episode, section: str, **fields: Any) -> Episode:
    """The episode under another protocol."""
    own = getattr(episode.protocol, section).model_copy(update=fields)
    return episode.model_copy(update={"protocol": episode.protocol.model_copy(update={section: own})})


@dataclass
class TrueMaps:
    """A store in which a tour is its visit's name and its map is true."""

    episode: Episode

    def __post_init__(self) -> None:
        seen, visits = sightings()[self.episode.id].sightings, self.episode.visits
        maps = {visits[which]: true_map(seen[which]) for which in ("first", "second")}
        self.perceived = Perceived(maps, {self.episode.noun: np.array([1.0, 0.0])})
        self.mapper, self.noun = lambda visit: maps[visit.content], self.perceived.noun
        self.detections_in = self.load_artifact = self.networks = None

    def visit(self, name, reachable):
        return Visit((), reachable, name)


def rollout(session: Session, arm: ArmJob, seed: int, episode: Episode) -> Rollout:
    return run_episode(session, Run(episode, arm, seed, settings(), TrueMaps(episode)))


@pytest.fixture(scope="module")
def session():
    with open_session(EPISODES[0], TWO_VISITS, settings()) as made:
        yield made


@pytest.mark.parametrize("relation", sorted({e.relation for e in EPISODES} - {Relation.MOVING}))
def test_with_true_maps_it_gets_there_and_draws_nothing(session, monkeypatch, relation):
    drawn = []
    step = Session.step

    def watched(self, action, image=False, **arguments):
        drawn.append((action, image))
        return step(self, action, image=image, **arguments)

    monkeypatch.setattr(Session, "step", watched)
    chosen = of(relation)
    run = rollout(session, TWO_VISITS, 0, chosen)
    assert run.outcome == "stopped" and run.arm == "two_visits_embodied" and run.episode == chosen.id
    assert is_success(run, relation, chosen.protocol.success)
    # Frames are drawn for the look-down sweep at the stop alone.
    assert {action for action, image in drawn if image} <= {"TeleportFull"}
    assert rollout(session, TWO_VISITS, 0, chosen) == run


def test_the_single_visit_draws_by_its_seed(session):
    arm = job("single_visit_embodied")[0]
    one, again, other = (rollout(session, arm, seed, of(Relation.FORMER)) for seed in (0, 0, 1))
    assert one == again and one.stop != other.stop


@pytest.mark.parametrize("budget", [4, 7, 300])
def test_a_run_that_is_cut_is_the_run_under_that_budget(session, budget):
    chosen = of(Relation.FORMER)
    whole = rollout(session, with_fields(TWO_VISITS, marks=(budget,)), 0, chosen)
    assert whole.outcome == "stopped" and 7 < whole.actions < 300
    short = rollout(session, with_fields(TWO_VISITS, budget=budget), 0, chosen)
    cut = scores.cut_rollout(whole, with_fields(TWO_VISITS, name="short", cut_from="two_visits_embodied", budget=budget))
    assert cut.model_copy(update={"path_at_m": None}) == short.model_copy(update={"arm": "short"})
    assert scores.cut_rollout(whole, TWO_VISITS) is whole


def test_a_run_that_left_no_mark_cannot_be_cut():
    whole = Rollout(episode="e", arm="long", seed=0, outcome="stopped", path_length_m=2.0, actions=9, **dict(NOWHERE))
    short = with_fields(TWO_VISITS, name="short", cut_from="long", budget=9)
    with pytest.raises(ValueError, match="e: long was not run for short; make its rollouts again"):
        scores.cut_rollout(whole, short)
    for actions, outcome in ((8, "stopped"), (9, "stalled"), (9, "budget")):
        ended = whole.model_copy(update={"actions": actions, "outcome": outcome})
        assert scores.cut_rollout(ended, short) == ended.model_copy(update={"arm": "short"})


class Watcher(Quiet):
    """Looks at whatever it is given, and stops."""

    def __init__(self, says: bool | None) -> None:
        self.frames = []
        if says is not None:
            self.looks = says

    def act(self, observation):
        self.frames.append(observation)
        return Action.STOP


@pytest.mark.parametrize(("says", "looks"), [(None, True), (True, True), (False, False)])
def test_frames_are_drawn_unless_an_agent_says_that_it_does_not_look(session, says, looks):
    agent = Watcher(says)
    assert isinstance(agent, Agent)
    run_agent(session, EPISODES[0], agent)
    (frame,) = agent.frames
    assert frame.positions is None and (frame.rgb is not None) == (frame.depth is not None) == looks


def test_a_threshold_that_changes_no_answer_is_no_new_run():
    chosen = EPISODES[0]
    store = TrueMaps(chosen)

    def key(settings, seed=0, episode=chosen, store=store):
        return rollout_key(Run(episode, TWO_VISITS, seed, settings, store))

    usual = key(settings())
    assert key(settings({"association.gate_m": 1.2501, "grounding.similarity_margin": 0.031})) == usual
    assert key(settings(), seed=1) != usual
    blind = TrueMaps(chosen)
    blind.perceived = Perceived(dict.fromkeys(store.perceived.maps, ()), store.perceived.nouns)
    assert key(settings(), store=blind) != usual


def test_what_judges_an_episode_is_no_part_of_its_runs():
    chosen = EPISODES[0]

    def key(episode):
        return rollout_key(Run(episode, TWO_VISITS, 0, settings(), TrueMaps(chosen)))

    usual = key(chosen)
    assert key(with_protocol(chosen, "success", radius_m=0.3, visible_px=7)) == usual
    for field, value in {"shortest_path_m": 1.0, "certification": (), "drift_m": {}, "split": "other"}.items():
        assert key(chosen.model_copy(update={field: value})) == usual, field
    moved = chosen.spawn.model_copy(update={"yaw_deg": 1.0})
    others = [
        with_protocol(chosen, "success", sweep_deg=(0, 30)),
        with_protocol(chosen, "primitives", stop_within_m=0.61),
        with_protocol(chosen, "primitives", stall_after=81),
        chosen.model_copy(update={"spawn": moved}),
        chosen.model_copy(update={"answer": (0.0, 0.0)}),
        chosen.model_copy(update={"changes": ()}),
        chosen.model_copy(update={"provenance": chosen.provenance.model_copy(update={"seed": 1})}),
    ]
    assert len({usual, *map(key, others)}) == 1 + len(others)


def test_an_arm_that_executes_nobodys_answer_is_run_again_when_what_it_sees_or_reads_changes(tmp_path):
    chosen = EPISODES[0]
    arm = with_fields(TWO_VISITS, executes=None, executed=None)
    files = {"maps": tmp_path / f"{SCENE}.npz", "nouns": tmp_path / "nouns.npz"}
    perceived = TrueMaps(chosen).perceived

    def key(overrides=None, seed=0):
        return rollout_key(Run(chosen, arm, seed, settings(overrides), ObservationStore(arm, settings(), 90.0, tmp_path, files)))

    write_nouns(files["nouns"], perceived.nouns)
    write_maps(files["maps"], perceived.maps)
    usual = key()
    assert key() == usual != key(seed=1)
    assert key({"association.gate_m": 1.2501}) != usual
    write_maps(files["maps"], dict.fromkeys(perceived.maps, ()))
    assert key() != usual
