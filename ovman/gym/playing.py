"""An agent of `ovman.agents.interface` in the environment: observations from dictionaries, actions as numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from hashlib import sha256
from typing import Any

import gymnasium
import numpy as np

from ovman.agents.interface import Action, AgentContext, CameraPose, Observation, Query, Visit
from ovman.evaluation.supervision import load_agent
from ovman.gym.environment import Environment
from ovman.gym.episodes import AGENT
from ovman.gym.spaces import ACTIONS, CATEGORIES, RELATIONS
from ovman.records.run import Score
from ovman.runner import drive


class GymnasiumAdapter:
    """The environment "OVMAN-v1", after a reset, as the loop of all agents steps it (`ovman.runner.Steppable`)."""

    def __init__(self, env: gymnasium.Env[dict[str, Any], np.int64], given: Mapping[str, Any], field_of_view_deg: float) -> None:
        """Wrap an environment. given: The observation of its reset."""
        self._env, self._given, self._field_of_view_deg = env, given, field_of_view_deg
        self.looks, self.reachable = True, reachable_of(given)

    def observe(self) -> Observation:
        """Return the last observation."""
        return observation_of(self._given, self._field_of_view_deg, self.looks)

    def step(self, action: Action) -> tuple[Observation, bool]:
        """Step the environment."""
        self._given, _, terminated, truncated, _ = self._env.step(np.int64(ACTIONS.index(action)))
        return self.observe(), terminated or truncated


def play(
    env: gymnasium.Env[dict[str, Any], np.int64],
    episode: str,
    seed: int,
    make_agent: Callable[[AgentContext], Any] | None = None,
) -> Score:
    """Run an agent on an episode of "OVMAN-v1" under a seed. The score is that of `ovman eval` under the same name.

    Args:
        env: The environment.
        episode: Id of the episode.
        seed: Of the run.
        make_agent: Makes the agent; the function of the environment's arm if None. Its errors are not caught.

    Raises:
        TypeError: Another environment.
        ValueError: No `make_agent`, and the environment has no arm's name.
    """
    if not isinstance(bare := env.unwrapped, Environment):
        raise TypeError(f"{type(bare).__name__} is no OVMAN-v1; make one with gymnasium.make")
    if make_agent is None:
        if bare.arm.agent == AGENT:
            raise ValueError(
                f"{bare.arm.name} is no arm of config.yaml; make the environment with the name of one, or give an agent"
            )
        make_agent = load_agent(bare.arm.name, bare.arm.agent)
    given, info = env.reset(seed=seed, options={"episode": episode})
    context, lens, tours = bare.context(), info["field_of_view_deg"], given | info
    adapter = GymnasiumAdapter(env, given, lens)
    visits = {"first": visit_of("first", tours, lens, np.empty((0, 2)))}
    visits["second"] = visit_of("second", tours, lens, adapter.reachable)
    context.visits += visits.values()
    drive(adapter, make_agent(context), lambda which, reachable: visits[which], query_of(given))
    assert bare.run is not None, "the run has ended"
    return bare.run


def observation_of(given: Mapping[str, Any], field_of_view_deg: float, looks: bool) -> Observation:
    """Return what an agent observes. looks: Whether it takes images; ValueError if it does and there are none."""
    if looks and "rgb" not in given:
        raise ValueError("the agent takes images and the environment was made without; make it with looks=True")
    return Observation(
        given["rgb"] if looks else None,
        given["depth"] if looks else None,
        CameraPose(*given["pose"].tolist()),
        field_of_view_deg,
        bool(given["last_action_succeeded"]),
        None,
        reachable_of(given) if given["reachable_anew"] else None,
    )


def reachable_of(given: Mapping[str, Any]) -> np.ndarray:
    """Return the positions (K, 2) that can be reached, metres."""
    positions: np.ndarray = given["reachable"][: given["reachable_count"]]
    return positions


def visit_of(which: str, given: Mapping[str, Any], field_of_view_deg: float, reachable: np.ndarray) -> Visit:
    """Return the visit "first" or "second". given: An observation, or the information of a reset, that has the tours."""
    shown = [given[f"{which}_{part}"] for part in ("rgb", "depth", "pose")]
    views = zip(*shown[:2], shown[2].tolist(), strict=True)
    frames = tuple(Observation(rgb, depth, CameraPose(*at), field_of_view_deg) for rgb, depth, at in views)
    content = sha256(repr(field_of_view_deg).encode())
    for array in shown:
        content.update(np.ascontiguousarray(array).data)
    return Visit(frames, reachable, content.hexdigest())


def query_of(given: Mapping[str, Any]) -> Query:
    """Return the query."""
    return Query(CATEGORIES[given["category"]], RELATIONS[given["relation"]])
