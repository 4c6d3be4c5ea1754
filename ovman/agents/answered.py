"""The agent that drives to an answer that it is given. It reads no tour and decides nothing."""

from __future__ import annotations

from ovman.agents.interface import Abstention, Action, AgentContext, Answer, Observation, Query, Visit
from ovman.agents.pilot import Pilot


class Driver:
    """Drives to an answer as the agents of this package drive to their own. It takes no images while it drives."""

    looks = False

    def __init__(self, pilot: Pilot, answered: Answer | Abstention) -> None:
        self._pilot, self._answered = pilot, answered

    def familiarise(self, visit: Visit) -> None:
        """Keeps nothing."""

    def revisit(self, visit: Visit) -> None:
        """Keeps the grid on which to navigate."""
        self._reachable = visit.reachable

    def ask(self, query: Query) -> None:
        """Sets out."""
        self._pilot.set_out(self._reachable, query.relation)

    def act(self, observation: Observation) -> Action:
        """One primitive towards the answer; ABSTAIN without one."""
        if isinstance(self._answered, Abstention):
            return Action.ABSTAIN
        return self._pilot.act(observation, (self._answered.x, self._answered.z))


def driver(context: AgentContext) -> Driver | None:
    """The agent that drives to what the context offers; None where it offers nothing."""
    return None if context.answered is None else Driver(context.pilot, context.answered)
