"""The diagnostic of the two-visit reference agent with true positions: association, decision, navigation. No perception."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ovman.agents.interface import (
    Abstention,
    Action,
    AgentContext,
    Answer,
    Observation,
    PredictionContext,
    Query,
    Relation,
    Visit,
)
from ovman.agents.oracle import followed
from ovman.agents.pilot import Pilot
from ovman.agents.reference.association import associate
from ovman.agents.reference.decision import decide
from ovman.records.world_state import Instance, WorldState
from ovman.settings import Settings


def answer(query: Query, world_1: WorldState, world_2: WorldState, settings: Settings) -> Answer | Abstention:
    """What the agent answers from the recorded positions of both visits. Identities are not compared across visits.

    settings: association.* and admissibility.tau_m.
    """
    first = sorted(world_1.category(query.category), key=lambda k: (k.x, k.z))
    second = sorted(world_2.category(query.category), key=lambda k: (k.x, k.z))
    p_1, p_2 = _points(first), _points(second)
    constants = settings.association
    matched = associate(p_1, p_2, gate_m=constants.gate_m, feature_scale_m=constants.feature_scale_m)
    return decide(
        query.relation,
        p_1,
        p_2,
        matched,
        [np.array(k.track) for k in second],
        tau_m=settings.admissibility.tau_m,
        track_spread_m=constants.track_spread_m,
    )


def _points(instances: list[Instance]) -> np.ndarray:
    return np.array([(k.x, k.z) for k in instances], dtype=float).reshape(-1, 2)


def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arm positions_two_visits."""
    return answer(query, context.world("first"), context.world("second"), context.settings), None


class PositionsTwoVisits:
    """The reference agent of the embodied row "oracle pos"."""

    def __init__(self, pilot: Pilot, settings: Settings) -> None:
        self._pilot, self._settings = pilot, settings

    def familiarise(self, visit: Visit) -> None:
        """Keeps where everything was."""
        self._first = remembered(visit)

    def revisit(self, visit: Visit) -> None:
        """Keeps where everything is, and the grid on which to navigate."""
        self._second, self._reachable = remembered(visit), visit.reachable

    def ask(self, query: Query) -> None:
        """Decides once; the goal of a MOVING query is the instance, for the other relations a point."""
        self._decided = answer(query, self._first, self._second, self._settings)
        self._follow: str | None = None
        if query.relation is Relation.MOVING and isinstance(self._decided, Answer):
            at = (self._decided.x, self._decided.z)
            self._follow = next(k.id for k in self._second.category(query.category) if k.track[-1] == at)
        self._pilot.set_out(self._reachable, query.relation)

    def act(self, observation: Observation) -> Action:
        """One primitive towards the answer; ABSTAIN without an answer."""
        if isinstance(self._decided, Abstention):
            return Action.ABSTAIN
        return self._pilot.act(observation, followed(observation, self._follow) or (self._decided.x, self._decided.z))


def agent(context: AgentContext) -> PositionsTwoVisits:
    """The embodied arm two_visits_oracle_positions."""
    return PositionsTwoVisits(context.pilot, context.settings)


def remembered(visit: Visit) -> WorldState:
    """The instances of a visit with true positions: last position and track of each."""
    tracks: dict[str, list[tuple[float, float]]] = {}
    categories: Mapping[str, str] = {s.instance: s.category for o in visit.observations for s in o.positions or ()}
    for observation in visit.observations:
        for seen in observation.positions or ():
            tracks.setdefault(seen.instance, []).append((seen.x, seen.z))
    return WorldState(tuple(Instance(k, categories[k], *track[-1], tuple(track)) for k, track in sorted(tracks.items())))
