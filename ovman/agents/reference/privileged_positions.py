"""The two-visit reference agent with positions handed over: association, decision, navigation. No perception."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ovman.agents.interface import Action, Observation, Visit
from ovman.agents.oracle import followed
from ovman.agents.pilot import Pilot
from ovman.agents.reference.association import associate
from ovman.agents.reference.decision import Abstention, Answer, DecisionConstants, decide
from ovman.models.settings import Settings
from ovman.task import Instance, Query, Relation, WorldState

if TYPE_CHECKING:
    from ovman.evaluation.context import Given, Recorded


@dataclass(frozen=True)
class AssociationConstants:
    """gate_m: gamma; feature_scale_m: lambda, metres per unit of feature disagreement."""

    gate_m: float
    feature_scale_m: float

    @staticmethod
    def of(constants: Settings) -> AssociationConstants:
        """Those of config.yaml; `constants` must own association.*."""
        return AssociationConstants(constants.association.gate_m, constants.association.feature_scale_m)


def answer(
    query: Query, world_1: WorldState, world_2: WorldState, association: AssociationConstants, decision: DecisionConstants
) -> Answer | Abstention:
    """What the agent answers from the recorded positions of both visits. Identities are not compared across visits."""
    first = sorted(world_1.category(query.category), key=lambda k: (k.x, k.z))
    second = sorted(world_2.category(query.category), key=lambda k: (k.x, k.z))
    p_1, p_2 = _points(first), _points(second)
    matched = associate(p_1, p_2, gate_m=association.gate_m, feature_scale_m=association.feature_scale_m)
    return decide(query.relation, p_1, p_2, matched, [np.array(k.track) for k in second], decision)


def _points(instances: list[Instance]) -> np.ndarray:
    return np.array([(k.x, k.z) for k in instances], dtype=float).reshape(-1, 2)


def predict(query: Query, recorded: Recorded) -> tuple[Answer | Abstention, None]:
    """The static arm positions_two_visits."""
    constants = AssociationConstants.of(recorded.constants), DecisionConstants.of(recorded.constants)
    return answer(query, recorded.world("first"), recorded.world("second"), *constants), None


def agent(given: Given) -> TwoVisits:
    """The embodied arm two_visits_oracle_positions."""
    return TwoVisits(given.pilot, AssociationConstants.of(given.constants), DecisionConstants.of(given.constants))


class TwoVisits:
    """The reference agent of the embodied row "oracle pos"."""

    def __init__(self, pilot: Pilot, association: AssociationConstants, decision: DecisionConstants) -> None:
        self._pilot, self._association, self._decision = pilot, association, decision

    def familiarise(self, visit: Visit) -> None:
        """Keeps where everything was."""
        self._first = remembered(visit)

    def revisit(self, visit: Visit) -> None:
        """Keeps where everything is, and the grid on which to navigate."""
        self._second, self._reachable = remembered(visit), visit.reachable

    def ask(self, query: Query) -> None:
        """Decides once; the goal of a MOVING query is the instance, for the other relations a point."""
        self._decided = answer(query, self._first, self._second, self._association, self._decision)
        self._follow: str | None = None
        if query.relation is Relation.MOVING and isinstance(self._decided, Answer):
            at = (self._decided.x, self._decided.z)
            self._follow = next(k.id for k in self._second.category(query.category) if k.track[-1] == at)
        self._pilot.set_out(self._reachable, query.relation)

    def act(self, observation: Observation) -> Action:
        """One primitive towards the answer; ABSTAIN if there is none."""
        if isinstance(self._decided, Abstention):
            return Action.ABSTAIN
        return self._pilot.act(observation, followed(observation, self._follow) or (self._decided.x, self._decided.z))


def remembered(visit: Visit) -> WorldState:
    """The instances of a visit with handed positions: last position and track of each."""
    tracks: dict[str, list[tuple[float, float]]] = {}
    categories: Mapping[str, str] = {s.instance: s.category for o in visit.observations for s in o.positions or ()}
    for observation in visit.observations:
        for seen in observation.positions or ():
            tracks.setdefault(seen.instance, []).append((seen.x, seen.z))
    return WorldState(tuple(Instance(k, categories[k], *track[-1], tuple(track)) for k, track in sorted(tracks.items())))
