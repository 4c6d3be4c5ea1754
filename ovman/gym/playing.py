"""An agent of `ovman.agents.interface` in the environment: what it is given, from the dictionary; what it does, as a number."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

from ovman.agents.interface import AgentContext
from ovman.evaluation.supervision import load_agent
from ovman.gym.encoding import observation_of, query_of, reachable_of, visit_of
from ovman.gym.environment import Environment
from ovman.gym.episodes import AGENT
from ovman.gym.spaces import ACTIONS
from ovman.records.run import Score


def play(
    env: gymnasium.Env[dict[str, Any], np.int64],
    episode: str,
    seed: int,
    made: Callable[[AgentContext], Any] | None = None,
) -> Score:
    """The run of an agent on an episode of "OVMAN-v1" under a seed, judged: that of `ovman eval`, where the names are equal.

    made: what makes the agent; None for that of the environment's arm. What it raises is not caught. TypeError for another
    environment, ValueError where it has no arm's name.
    """
    if not isinstance(bare := env.unwrapped, Environment):
        raise TypeError(f"{type(bare).__name__} is no OVMAN-v1; make one with gymnasium.make")
    if made is None:
        if bare.arm.agent == AGENT:
            raise ValueError(f"{bare.arm.name} is no arm of config.yaml; make the environment with the name of one, or give made")
        made = load_agent(bare.arm.name, bare.arm.agent)
    given, info = env.reset(seed=seed, options={"episode": episode})
    context, lens, tours = bare.context(), info["field_of_view_deg"], given | info
    context.visits += [visit_of("first", tours, lens, np.empty((0, 2))), visit_of("second", tours, lens, reachable_of(given))]
    agent = made(context)
    agent.familiarise(context.visits[0])
    agent.revisit(context.visits[1])
    agent.ask(query_of(given))
    looks, over = getattr(agent, "looks", True), False
    while not over:
        action = agent.act(observation_of(given, lens, looks))
        given, _, terminated, truncated, _ = env.step(np.int64(ACTIONS.index(action)))
        over = terminated or truncated
    run = bare.run
    assert run is not None, "the run has ended"
    return run
