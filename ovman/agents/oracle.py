"""The oracle agent: it knows the true answer and drives there with the shared navigator (Algorithm 1, lines 9 and 10)."""

from __future__ import annotations

from ovman.agents.interface import Action, AgentContext, Instruction, Observation, Query, Visit
from ovman.agents.pilot import Pilot


class Oracle:
    """An agent that knows the answer. For MOVING it reads the position of the moving target from observations.

    answer: floor-plane point in metres; follow: name of the moving target in observations, or None.
    """

    def __init__(self, pilot: Pilot, answer: tuple[float, float], follow: str | None) -> None:
        self._pilot, self._answer, self._follow = pilot, answer, follow

    def familiarise(self, visit: Visit) -> None:
        """Do nothing: the oracle has nothing to learn."""

    def revisit(self, visit: Visit) -> None:
        """Take the grid for navigation."""
        self._reachable = visit.reachable

    def ask(self, query: Instruction) -> None:
        """Set out to the known answer."""
        self._pilot.set_out(self._reachable, query.relation if isinstance(query, Query) else None)

    def act(self, observation: Observation) -> Action:
        """Return the next primitive towards the answer."""
        return self._pilot.act(observation, find_instance(observation, self._follow) or self._answer)


def agent(context: AgentContext) -> Oracle:
    """Make the agent of the embodied arm oracle_check. Raises ValueError for an arm that is not given the answer."""
    if context.privileged is None:
        raise ValueError("an oracle is told the answer; write answer: handed in its entry")
    return Oracle(context.pilot, context.privileged.answer, context.privileged.follow)


def find_instance(observation: Observation, name: str | None) -> tuple[float, float] | None:
    """Return the position of the instance `name` in an observation with positions; None if it is not among them."""
    if name is None or observation.positions is None:
        return None
    return next(((seen.x, seen.z) for seen in observation.positions if seen.instance == name), None)
