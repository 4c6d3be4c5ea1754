"""Agents that get the grid of visit 1: it tells nothing of visit 2, does not follow movers, and the pilot copes with it."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.agents.interface import Action
from ovman.agents.pilot import Pilot
from ovman.env import Env, Terms, prepare_world
from ovman.evaluation.scores import score_rollout
from ovman.records.episode import Episode
from ovman.remote.agent import begin_message
from ovman.runner import Run, open_env, open_session, run_episode
from ovman.settings.splits import Rules
from ovman.sim.measurement import ReachableRegion
from ovman.sim.session import AgentPose
from ovman.sim.world import World
from tests.episodes import DATA
from tests.runs import Quiet, job

PAPER, FIRST = Rules(), Rules(grid="first")
RELATIONS = ("appeared", "removed", "moving")


@pytest.fixture(scope="module")
def pair():
    """Episodes of a world pair in which furniture stands on the grid of visit 1 and moves."""
    pairs: dict[str, list[Episode]] = {}
    for one in Episode.load(DATA / "episodes" / "dev_everyday.jsonl"):
        pairs.setdefault(one.pair, []).append(one.model_copy(update={"rules": FIRST}))
    return next(found for found in pairs.values() if {*RELATIONS} <= {one.relation.value for one in found})


@pytest.fixture(scope="module")
def episodes(pair):
    """One episode per relation."""
    return {one.relation.value: one for one in pair}


@pytest.fixture(scope="module")
def session(episodes):
    arm, settings = job("oracle_check")
    with open_session(episodes["moving"], arm, settings) as made:
        yield made


def by_paper(episode: Episode) -> Episode:
    return episode.model_copy(update={"rules": PAPER})


def cells(session, spawn) -> set:
    region = ReachableRegion.around(session, AgentPose(spawn.x, spawn.z, spawn.yaw_deg), 0.25)
    return {tuple(np.round(region.grid.centre(cell), 4)) for cell in region.grid.cells}


def told(positions) -> set:
    return {tuple(row) for row in np.round(positions, 4)}


@pytest.mark.parametrize("name", RELATIONS)
def test_the_grid_is_that_of_visit_1_in_both_visits_and_throughout_the_run(session, episodes, name):
    episode = episodes[name]
    World(session, episode.alterations("first"), episode.settings.mover, np.random.default_rng(0))
    session.teleport(AgentPose(episode.spawn.x, episode.spawn.z, 0.0))
    first = cells(session, episode.spawn)
    env = Env(session, episode.settings)
    assert env.reset(episode, Terms(np.random.default_rng(0)), looks=False).reachable is None
    assert told(env.reachable) == told(env.reachable_first) == first
    prepare_world(session, episode, episode.settings, np.random.default_rng(0))
    session.teleport(AgentPose(episode.spawn.x, episode.spawn.z, 0.0))
    assert cells(session, episode.spawn) != first  # the exact one, which shows what has changed
    env.reset(episode, Terms(np.random.default_rng(0)), looks=False)
    assert all(env.step(Action.ROTATE_LEFT)[0].reachable is None for _ in range(30))


def test_by_the_paper_s_rules_the_grid_of_visit_2_follows_movers(session, episodes):
    episode = by_paper(episodes["moving"])
    env = Env(session, episode.settings)
    env.reset(episode, Terms(np.random.default_rng(0)), looks=False)
    assert env.reachable_first.shape == (0, 2)
    assert any(env.step(Action.ROTATE_LEFT)[0].reachable is not None for _ in range(30))


def test_an_agent_is_given_it_with_both_visits(session, episodes):
    seen = []

    class Listening(Quiet):
        def familiarise(self, visit):
            seen.append(visit.reachable)

        revisit = familiarise

        def act(self, observation):
            return Action.ABSTAIN

    episode, (arm, settings) = episodes["appeared"], job("oracle_check")
    run_episode(session, Run(episode, arm, 0, settings), lambda run: Listening())
    assert len(seen) == 2 and len(seen[0]) > 0 and told(seen[0]) == told(seen[1])


@pytest.mark.parametrize("name", RELATIONS)
def test_the_oracle_arrives_although_furniture_stands_on_its_grid(session, episodes, name):
    episode, (arm, settings) = episodes[name], job("oracle_check")
    run = Run(episode, arm, 0, settings)
    made = score_rollout(run_episode(session, run), episode)
    assert made.success and 0 < made.spl <= 1  # L* is that of the exact grid, which the episode has


def test_a_pilot_that_trusts_the_grid_of_visit_1_does_not_always_arrive(session, pair):
    class Trusting:
        """The oracle as it was: every cell of its grid is free."""

        def __init__(self, run):
            self.pilot, self.answer = Pilot(run.episode.protocol.primitives, np.random.default_rng(0)), run.episode.answer

        def familiarise(self, visit):
            self.reachable = visit.reachable

        revisit = familiarise

        def ask(self, query):
            self.pilot.set_out(self.reachable, query.relation)

        def act(self, observation):
            return self.pilot.act(observation, self.answer)

    arm, settings = job("oracle_check")
    assert not all(score_rollout(run_episode(session, Run(one, arm, 0, settings), Trusting), one).success for one in pair)


def test_a_remote_agent_is_told_which_grid_it_gets(episodes):
    (arm, settings), episode = job("two_visits_embodied"), episodes["appeared"]
    assert [begin_message(Run(one, arm, 0, settings))["grid"] for one in (by_paper(episode), episode)] == ["second", "first"]


def test_movers_walk_alike_under_all_arms_by_a_rule_of_the_split(session, episodes):
    """Before, an arm's name was in the stream, so paired runs met other walks."""
    plain = by_paper(episodes["moving"])
    alike = plain.model_copy(update={"rules": Rules(same_walk=True)})

    def walks(episode, arm, seed=0):
        of_arm, settings = job(arm)
        env = open_env(session, Run(episode, of_arm, seed, settings))
        for _ in range(30):
            env.step(Action.ROTATE_LEFT)
        return env._world.paths

    arms = ("oracle_check", "two_visits_embodied")
    assert walks(plain, arms[0]) != walks(plain, arms[1])
    assert walks(alike, arms[0]) == walks(alike, arms[1]) != walks(alike, arms[0], seed=1)
