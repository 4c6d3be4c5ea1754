"""The embodied arm: it drives to what it decided on, and follows what moves with its own eyes."""

from __future__ import annotations

from ovman.agents.interface import Abstention, Action, AgentContext, Observation, Query, Relation, Visit
from ovman.agents.joint.answers import answer
from ovman.agents.joint.naming import Nouns
from ovman.agents.joint.pursuit import Pursuit
from ovman.agents.joint.recorded import of_tours, read
from ovman.settings import Need


class JointAgent:
    """It decides once, when it is asked. For MOVING alone it takes images while it drives; `ask` says so."""

    looks = False

    def __init__(self, context: AgentContext) -> None:
        self._context = context

    def familiarise(self, visit: Visit) -> None:
        """Keeps the first tour."""
        self._first = visit

    def revisit(self, visit: Visit) -> None:
        """Weighs both tours against each other."""
        self._second = visit
        self._evidence = of_tours(self._context.made(Need.SEGMENTS, read), self._first, visit)

    def ask(self, query: Query) -> None:
        """Decides, and for MOVING gets ready to look for what moves."""
        settings = self._context.settings
        self._goal = answer(query, *self._evidence, Nouns(self._context.noun, settings.joint), settings.joint)
        self._pursuit = None
        if query.relation is Relation.MOVING and not isinstance(self._goal, Abstention):
            self._pursuit = Pursuit(self._second, (self._goal.x, self._goal.z), settings)
        self.looks = self._pursuit is not None
        self._context.pilot.set_out(self._second.reachable, query.relation)

    def act(self, observation: Observation) -> Action:
        """One primitive towards the answer, or towards where it saw last what it follows; ABSTAIN without an answer."""
        if isinstance(self._goal, Abstention):
            return Action.ABSTAIN
        if self._pursuit is None:
            return self._context.pilot.act(observation, (self._goal.x, self._goal.z))
        self._pursuit.look(observation)
        if self._pursuit.searching:
            return self._pursuit.turn()
        action = self._context.pilot.act(observation, self._pursuit.place)
        return self._pursuit.turn() if action is Action.STOP and self._pursuit.lost else action


def agent(context: AgentContext) -> JointAgent:
    """The embodied arm."""
    return JointAgent(context)
