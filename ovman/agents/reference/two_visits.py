"""The two-visit reference agent: it maps both visits, grounds the noun, associates the visits, decides and drives there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ovman.agents.interface import (
    Abstention,
    Action,
    AgentContext,
    Answer,
    Evidence,
    Mapper,
    Observation,
    PredictionContext,
    Query,
    Visit,
)
from ovman.agents.pilot import Pilot
from ovman.agents.reference.reasoning import two_visits_asked, two_visits_recorded
from ovman.language import noun
from ovman.perception.object_map import ObjectMap
from ovman.settings import Settings

Nouns = Callable[[str], np.ndarray]
"""From a noun phrase to its unit embedding (K,), by the encoder that made the features of the maps."""


class ReferenceAgent:
    """The two-visit reference agent. It keeps the maps of both visits, and takes no images while it drives.

    mapper: makes the map of a visit; nouns: embeds noun phrases; settings: as for `ovman.agents.reference.reasoning`. For MOVING
    it drives to where it saw the target last.
    """

    looks = False

    def __init__(self, pilot: Pilot, mapper: Mapper, nouns: Nouns, settings: Settings) -> None:
        self._pilot, self._mapper, self._nouns, self._settings = pilot, mapper, nouns, settings
        self._goal: Answer | Abstention | None = None

    def familiarise(self, visit: Visit) -> None:
        """Keeps the map of the first visit."""
        self._goal = None
        self._first = ObjectMap.of(self._mapper(visit))

    def revisit(self, visit: Visit) -> None:
        """Keeps the map of the second visit, and the grid on which to navigate."""
        self._second, self._reachable = ObjectMap.of(self._mapper(visit)), visit.reachable

    def ask(self, query: Query) -> None:
        """Decides once."""
        self._goal = self._decided(query, self._nouns(noun(query.category)))
        self._pilot.set_out(self._reachable, query.relation)

    def act(self, observation: Observation) -> Action:
        """One primitive towards the answer; ABSTAIN without an answer."""
        assert self._goal is not None, "ask comes first"
        if isinstance(self._goal, Abstention):
            return Action.ABSTAIN
        return self._pilot.act(observation, (self._goal.x, self._goal.z))

    def _decided(self, query: Query, phrase: np.ndarray) -> Answer | Abstention:
        return two_visits_asked(query.relation, self._first, self._second, phrase, self._settings)[0]


def agent(context: AgentContext) -> ReferenceAgent:
    """The embodied arm two_visits_embodied."""
    return ReferenceAgent(context.pilot, context.mapper, context.noun, context.settings)


def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, Evidence]:
    """The static arms two_visits and grounding_two_visits."""
    return two_visits_recorded(query, context, context.map("first"), context.map("second"))
