"""The reference agent: maps of its own, the noun grounded in them, the visits associated, a decision, and the way there."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ovman.agents.interface import VISITS, Action, Observation, Visit
from ovman.agents.pilot import Pilot
from ovman.agents.reference.decision import Abstention, Answer
from ovman.agents.reference.grounding import grounded
from ovman.agents.reference.mapper import Mapper
from ovman.agents.reference.object_map import ObjectMap
from ovman.agents.reference.reasoning import (
    Evidence,
    ReferenceConstants,
    means_of,
    one_visit,
    two_visits_asked,
    two_visits_recorded,
)
from ovman.agents.reference.single_visit import UniformBox, UniformPick
from ovman.language import noun
from ovman.task import Query

if TYPE_CHECKING:
    from ovman.evaluation.context import Given, Recorded

Nouns = Callable[[str], np.ndarray]
"""From a noun phrase to its unit embedding (K,), by the encoder that made the features of the maps."""


class ReferenceAgent:
    """The two-visit reference agent. It keeps the maps of both visits, and looks at nothing on its way.

    mapper: its eyes; nouns: its words. For MOVING it drives to where it saw the target last.
    """

    looks = False

    def __init__(self, pilot: Pilot, mapper: Mapper, nouns: Nouns, constants: ReferenceConstants) -> None:
        self._pilot, self._mapper, self._nouns, self._constants = pilot, mapper, nouns, constants
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
        """One primitive towards the answer; ABSTAIN if there is none."""
        assert self._goal is not None, "ask comes first"
        if isinstance(self._goal, Abstention):
            return Action.ABSTAIN
        return self._pilot.act(observation, (self._goal.x, self._goal.z))

    def _decided(self, query: Query, phrase: np.ndarray) -> Answer | Abstention:
        return two_visits_asked(query.relation, self._first, self._second, phrase, self._constants)[0]


class SingleVisitAgent(ReferenceAgent):
    """The single-visit baseline: the same eyes and words with no retained past. `rng` draws what it picks."""

    def __init__(
        self, pilot: Pilot, mapper: Mapper, nouns: Nouns, constants: ReferenceConstants, rng: np.random.Generator
    ) -> None:
        super().__init__(pilot, mapper, nouns, constants)
        self._rng = rng

    def familiarise(self, visit: Visit) -> None:
        """Keeps nothing."""
        self._goal = None

    def _decided(self, query: Query, phrase: np.ndarray) -> Answer | Abstention:
        means = grounded(self._second.f, phrase, self._constants.similarity_margin)
        return picked(one_visit(query.relation, self._second, means, self._reachable)[0], self._rng)


def picked(outcome: UniformPick | UniformBox | Abstention, rng: np.random.Generator) -> Answer | Abstention:
    """One draw of what a single-visit agent picks from; an abstention stays one. ValueError for a pick without candidates."""
    match outcome:
        case Abstention():
            return outcome
        case UniformPick(candidates):
            if not candidates:
                raise ValueError("there is nothing to pick from")
            return Answer(*candidates[int(rng.integers(len(candidates)))])
        case UniformBox(x_min, z_min, x_max, z_max):
            return Answer(float(rng.uniform(x_min, x_max)), float(rng.uniform(z_min, z_max)))


def two_visits_agent(given: Given) -> ReferenceAgent:
    """The embodied arm two_visits_embodied."""
    return ReferenceAgent(given.pilot, given.mapper, given.noun, ReferenceConstants.of(given.constants))


def single_visit_agent(given: Given) -> SingleVisitAgent:
    """The embodied arm single_visit_embodied."""
    return SingleVisitAgent(given.pilot, given.mapper, given.noun, ReferenceConstants.of(given.constants), given.rng)


def predict_two_visits(query: Query, recorded: Recorded) -> tuple[Answer | Abstention, Evidence]:
    """The static arms two_visits and grounding_two_visits."""
    return two_visits_recorded(query, recorded, [recorded.map(which) for which in VISITS])


def predict_single_visit(query: Query, recorded: Recorded) -> tuple[UniformPick | UniformBox | Abstention, Evidence]:
    """The static arms single_visit and grounding_single_visit."""
    objects = recorded.map("second")
    return one_visit(query.relation, objects, means_of(query, recorded, "second", objects), recorded.reachable)
