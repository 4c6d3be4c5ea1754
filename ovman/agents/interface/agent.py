"""The four methods of an agent under evaluation."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from ovman.agents.interface.observation import Action, Observation, Visit
from ovman.records.query import Query


@runtime_checkable
class Agent(Protocol):
    """An agent under evaluation, called in this order for every episode: familiarise, revisit, ask, then act until it ends.

    ``familiarise`` starts a new episode: an agent forgets what it kept of the last one. An agent that needs no images while it
    drives says so with an attribute `looks` that is False once ``ask`` has returned: `act` gets poses without images, and nothing
    is drawn for it. Without the attribute it gets images at every step. An exception raised by any of these ends the run of the
    evaluation, not the episode: an agent that cannot decide returns ABSTAIN.
    """

    def familiarise(self, visit: Visit) -> None:
        """The tour of the home before the change."""

    def revisit(self, visit: Visit) -> None:
        """The same tour after the change, which the agent did not see happen."""

    def ask(self, query: Query) -> None:
        """The category and the change relation that name the goal. Nothing was known of it during the tours."""

    def act(self, observation: Observation) -> Action:
        """The next primitive, given the frame at the present pose. The first call comes at the spawn.

        Called until STOP or ABSTAIN is returned or the action budget is spent, which is a failure.
        """
