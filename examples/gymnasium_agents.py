"""Run a random agent and the reference agent in the Gymnasium environment, and print the rates that `ovman eval` prints.

    python examples/gymnasium_agents.py                                       # --help lists the options
    ovman eval --arm two_visits_embodied --split dev --scenes FloorPlan6 --seeds 0 --out reference
    cd examples
    ovman eval --agent gymnasium_agents:Wanderer --name random --split dev --scenes FloorPlan6 --seeds 0 --out random

The random agent uses the loop of any Gymnasium agent. The reference agent was written against `ovman.agents.interface`;
`ovman.gym.playing.play` converts observations and actions for it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from typing import Any

import gymnasium
import numpy as np

import ovman.gym  # registers the environment
from ovman.agents.interface import Action, AgentContext, Observation, Query, Visit
from ovman.gym.playing import play
from ovman.gym.spaces import ACTIONS
from ovman.records.run import Score

WALK = 40
"""Moves of the random agent before it stops."""


class Wanderer:
    """An agent that moves and turns at random, then stops. `ovman eval` runs it too, with the same draws."""

    looks = False

    def __init__(self, context: AgentContext) -> None:
        self._drawn = self._draw(context.rng)

    @staticmethod
    def _draw(rng: np.random.Generator) -> Iterator[Action]:
        for _ in range(WALK):
            yield ACTIONS[int(rng.integers(ACTIONS.index(Action.STOP)))]
        yield Action.STOP

    def familiarise(self, visit: Visit) -> None:
        """Ignore the tour."""

    def revisit(self, visit: Visit) -> None:
        """Ignore the tour."""

    def ask(self, query: Query) -> None:
        """Ignore the query."""

    def act(self, observation: Observation | None) -> Action:
        """Return the next drawn action."""
        return next(self._drawn)


def wander(env: gymnasium.Env[dict[str, Any], np.int64], episode: str, seed: int) -> Score:
    """Run one episode with the loop of a Gymnasium agent, ignoring the observations."""
    env.reset(seed=seed, options={"episode": episode})
    agent, over = Wanderer(env.unwrapped.context()), False
    while not over:
        action = ACTIONS.index(agent.act(None))
        observation, reward, terminated, truncated, info = env.step(action)
        over = terminated or truncated
    run: Score = env.unwrapped.run
    assert info["is_success"] == run.success == (reward == 1.0)
    return run


def main(arguments: Sequence[str] | None = None) -> dict[str, list[Score]]:
    """Print the rates and return the runs by agent."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arm", default="two_visits_embodied", help="an arm; default: the reference agent")
    parser.add_argument("--split", default="dev")
    parser.add_argument("--episodes", metavar="FILE", help="a file of episodes instead of a split")
    parser.add_argument("--scenes", nargs="+", default=(), metavar="NAME", help="default: FloorPlan6 of a split")
    parser.add_argument("--first", type=int, default=None, metavar="N", help="run only the first N episodes")
    parser.add_argument("--seeds", nargs="+", type=int, default=[0], metavar="N")
    parser.add_argument("--cache", metavar="DIR", help="folder of recorded tours; default: the user's cache")
    options = parser.parse_args(arguments)
    where = {"split": None if options.episodes else options.split, "episodes": options.episodes}
    scenes = options.scenes or (() if options.episodes else ("FloorPlan6",))
    found = {}
    for name, run in (("random", wander), (options.arm, play)):
        # Neither agent looks at pictures while it navigates, and the tours do not change during a run.
        env = gymnasium.make(ovman.gym.ID, **where, scenes=scenes, name=name, looks=False, tours="reset", cache=options.cache)
        asked = env.unwrapped.episode_ids[: options.first]
        found[name] = [run(env, episode, seed) for seed in options.seeds for episode in asked]
        print(f"{name}: {len(asked)} episodes, {len(options.seeds)} seeds\n\n{env.unwrapped.rates(found[name])}\n")
        env.close()
    return found


if __name__ == "__main__":
    main()
