"""An agent of `ovman.agents.interface` in the environment: what it is given, from the dictionary; what it does, as a number."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

from ovman.agents.interface import AgentContext
from ovman.gym.encoding import observation_of, query_of, reachable_of, visit_of
from ovman.gym.environment import Environment
from ovman.gym.spaces import ACTIONS
from ovman.models.run import Score


def play(env: gymnasium.Env[dict[str, Any], np.int64], made: Callable[[AgentContext], Any], episode: str, seed: int) -> Score:
    """The run of an agent on an episode of "OVMAN-v1" under a seed, judged: that of `ovman eval`, where the names are equal.

    made: what makes the agent. What it raises is not caught. TypeError for another environment.
    """
    if not isinstance(bare := env.unwrapped, Environment):
        raise TypeError(f"{type(bare).__name__} is no OVMAN-v1; make one with gymnasium.make")
    given, info = env.reset(seed=seed, options={"episode": episode})
    agent, lens, tours = made(bare.context()), info["field_of_view_deg"], given | info
    agent.familiarise(visit_of("first", tours, lens, np.empty((0, 2))))
    agent.revisit(visit_of("second", tours, lens, reachable_of(given)))
    agent.ask(query_of(given))
    looks, over = getattr(agent, "looks", True), False
    while not over:
        action = agent.act(observation_of(given, lens, looks))
        given, _, terminated, truncated, _ = env.step(np.int64(ACTIONS.index(action)))
        over = terminated or truncated
    run = bare.run
    assert run is not None, "the run has ended"
    return run
