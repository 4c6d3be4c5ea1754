"""The embodied arm: it drives to the place that the memory of both tours has for the noun."""

from __future__ import annotations

from ovman.agents.dynamem.answers import located
from ovman.agents.dynamem.looks import Look, looks
from ovman.agents.dynamem.memory import remembered
from ovman.agents.interface import Abstention, Action, AgentContext, Observation, Query, Visit
from ovman.language import noun


class DynamemAgent:
    """DynaMem's memory of both tours. It takes no images while it drives."""

    looks = False

    def __init__(self, context: AgentContext) -> None:
        self._context = context
        self._first: tuple[Look, ...] = ()

    def familiarise(self, visit: Visit) -> None:
        """Keeps what the first tour shows."""
        self._first = self._seen(visit)

    def revisit(self, visit: Visit) -> None:
        """Keeps what the second tour shows, and the grid on which to navigate."""
        self._second, self._reachable = self._seen(visit), visit.reachable

    def ask(self, query: Query) -> None:
        """Decides once."""
        frames, constants = [*self._first, *self._second], self._context.settings.dynamem
        self._goal = located(remembered(frames, constants), frames, self._context.noun(noun(query.category)), constants)
        self._context.pilot.set_out(self._reachable, query.relation)

    def act(self, observation: Observation) -> Action:
        """One primitive towards the place; ABSTAIN without one."""
        if isinstance(self._goal, Abstention):
            return Action.ABSTAIN
        return self._context.pilot.act(observation, (self._goal.x, self._goal.z))

    def _seen(self, visit: Visit) -> tuple[Look, ...]:
        return looks(visit, self._context.detections(visit), self._context.settings.dynamem)


def agent(context: AgentContext) -> DynamemAgent:
    """The embodied arm."""
    return DynamemAgent(context)
