"""The single-visit baseline: the reference agent without the first visit.

It is a stochastic pick, not a realised policy: the static arm says what it picks from and the evaluator computes the probability
of success (`ovman.evaluation.scores.success_probability`). The embodied arm draws once. Source: the single-visit baseline of the
paper's problem formulation.
"""

from __future__ import annotations

import numpy as np

from ovman.agents.interface import (
    Abstention,
    AgentContext,
    Answer,
    Evidence,
    Mapper,
    PredictionContext,
    Query,
    UniformBox,
    UniformPick,
    Visit,
)
from ovman.agents.pilot import Pilot
from ovman.agents.reference.grounding import grounded
from ovman.agents.reference.reasoning import means_of, one_visit
from ovman.agents.reference.two_visits import Nouns, ReferenceAgent
from ovman.settings import Settings


class SingleVisitAgent(ReferenceAgent):
    """The reference agent without the first visit. `rng` draws what it picks."""

    def __init__(self, pilot: Pilot, mapper: Mapper, nouns: Nouns, settings: Settings, rng: np.random.Generator) -> None:
        super().__init__(pilot, mapper, nouns, settings)
        self._rng = rng

    def familiarise(self, visit: Visit) -> None:
        """Keeps nothing."""
        self._goal = None

    def _decided(self, query: Query, phrase: np.ndarray) -> Answer | Abstention:
        means = grounded(self._second.f, phrase, self._settings.grounding.similarity_margin)
        return picked(one_visit(query.relation, self._second, means, self._reachable)[0], self._rng)


def picked(outcome: UniformPick | UniformBox | Abstention, rng: np.random.Generator) -> Answer | Abstention:
    """One draw of what a single-visit agent picks from; an abstention stays one. ValueError for a pick without candidates."""
    match outcome:
        case Abstention():
            return outcome
        case UniformPick(candidates):
            if not candidates:
                raise ValueError("the pick has no candidates")
            return Answer(*candidates[int(rng.integers(len(candidates)))])
        case UniformBox(x_min, z_min, x_max, z_max):
            return Answer(float(rng.uniform(x_min, x_max)), float(rng.uniform(z_min, z_max)))


def agent(context: AgentContext) -> SingleVisitAgent:
    """The embodied arm single_visit_embodied."""
    return SingleVisitAgent(context.pilot, context.mapper, context.noun, context.settings, context.rng)


def predict(query: Query, context: PredictionContext) -> tuple[UniformPick | UniformBox | Abstention, Evidence]:
    """The static arms single_visit and grounding_single_visit."""
    objects = context.map("second")
    return one_visit(query.relation, objects, means_of(query, context, objects, "second"), context.reachable)
