"""The embodied arm: it drives to the place that the memory of both tours has for the noun."""

from __future__ import annotations

from ovman.agents.answered import Driver, driver
from ovman.agents.dynamem.answers import Tours, located
from ovman.agents.interface import Abstention, Action, AgentContext, Observation, Query, Visit
from ovman.language import noun
from ovman.records.prediction import as_recorded


class DynamemAgent:
    """DynaMem's memory of both tours. It takes no images while it drives."""

    looks = False

    def __init__(self, context: AgentContext) -> None:
        self._context = context

    def familiarise(self, visit: Visit) -> None:
        """Keeps the first tour."""
        self._first = visit

    def revisit(self, visit: Visit) -> None:
        """Keeps the second tour."""
        self._second = visit

    def ask(self, query: Query) -> None:
        """Remembers both tours and decides, once."""
        constants, tours = self._context.settings.dynamem, (self._first, self._second)
        both = Tours.of([(tour, self._context.detections(tour)) for tour in tours], constants).remembered()
        self._goal = as_recorded(located(*both, self._context.noun(noun(query.category)), constants))
        self._context.pilot.set_out(self._second.reachable, query.relation)

    def act(self, observation: Observation) -> Action:
        """One primitive towards the place; ABSTAIN without one."""
        if isinstance(self._goal, Abstention):
            return Action.ABSTAIN
        return self._context.pilot.act(observation, (self._goal.x, self._goal.z))


def agent(context: AgentContext) -> Driver | DynamemAgent:
    """The embodied arm."""
    return driver(context) or DynamemAgent(context)
