"""Runs of agents in tests: an agent in the environment of an episode, and the job of an arm of config.yaml."""

from __future__ import annotations

from typing import Any

import numpy as np

from ovman.agents.interface import Query, Visit
from ovman.env import Env, Terms
from ovman.records.run import Measured
from ovman.runner import drive
from ovman.settings import Settings
from ovman.settings.arms import ArmJob
from ovman.settings.settings import arm_job, settings_of_arm
from ovman.sim.session import Session
from tests.arms import CONFIG


class Quiet:
    """An agent that ignores tours and query."""

    def familiarise(self, given: Any) -> None:
        """Ignore what is given."""

    revisit = ask = familiarise


def run_agent(session: Session, episode: Any, agent: Any, settings: Settings | None = None, **terms: Any) -> Measured:
    """Run an agent that is shown no tours. terms: Those of `Terms` other than the draws of movers."""
    env = Env(session, episode.settings if settings is None else settings)
    env.reset(episode, Terms(np.random.default_rng(0), **terms), looks=False)
    drive(env, agent, lambda which, reachable: Visit((), reachable), Query(episode.query.category, episode.query.relation))
    return env.measured


def job(arm: str) -> tuple[ArmJob, Settings]:
    """Return an arm of config.yaml as its jobs are given it, and their settings."""
    return arm_job(CONFIG, arm), settings_of_arm(CONFIG, arm)
