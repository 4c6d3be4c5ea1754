"""The arms of the reference agent: two visits, one visit or one maintained map, with its own perception or true positions.

The two-visit agent maps both visits, grounds the noun, associates the visits, decides and drives there. The single-visit baseline
is a stochastic pick, not a realised policy: the static arm says what it picks from and the evaluator computes the probability of
success; the embodied arm draws once.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ovman.agents.interface import (
    VISITS,
    Abstention,
    AbstentionReason,
    Action,
    Answer,
    Evidence,
    Observation,
    PredictionContext,
    Query,
    Relation,
    UniformBox,
    UniformPick,
    Visit,
)
from ovman.agents.oracle import find_instance
from ovman.agents.pilot import GoalAgent
from ovman.agents.reference.association import associate
from ovman.agents.reference.reasoning import (
    answer_phrase,
    answer_query,
    decide,
    decide_by_spread,
    ground,
    ground_query,
    pick_grounded,
    pick_instance,
)
from ovman.agents.words import understands
from ovman.perception.clusters import ObjectMap
from ovman.perception.records import name_pair, read_maps
from ovman.records.task import Instance, WorldState
from ovman.settings import Need, Settings

# Static arms ------------------------------------------------------------------------------------------------------------------


@understands
def predict_two_visits(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, Evidence]:
    """Answer as the static arms two_visits and grounding_two_visits."""
    return answer_query(query, context, context.map("first"), context.map("second"))


@understands
def predict_single_visit(query: Query, context: PredictionContext) -> tuple[UniformPick | UniformBox | Abstention, Evidence]:
    """Answer as the static arms single_visit and grounding_single_visit."""
    objects = context.map("second")
    return pick_grounded(query.relation, objects, ground_query(query, context, objects, "second"), context.reachable)


def predict_maintained_map(query: Query, context: PredictionContext) -> tuple[UniformPick | Abstention, None]:
    """Answer as the static arms maintained_map and grounding_maintained_map: from one map that both visits maintain.

    The map holds former and present places side by side, so every grounded object is as good an answer as the others: a pick
    among their places, for MOVING their last track points. Abstains with NOTHING_GROUNDED without one. Source: the paper's Fig.
    memory, "one current-state reading".
    """
    name = name_pair(context.visits.first, context.visits.second)
    objects = ObjectMap.of(context.made(Need.MAINTAINED, read_maps)[name])
    grounded = ground_query(query, context, objects, *VISITS)
    if not grounded:
        return Abstention(AbstentionReason.NOTHING_GROUNDED), None
    moving = query.relation is Relation.MOVING
    places = [objects.tracks[i][-1] if moving else objects.p[i] for i in grounded]
    return UniformPick(tuple(sorted((float(x), float(z)) for x, z in places))), None


def predict_positions_two_visits(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm positions_two_visits: no perception, no grounding."""
    return answer_positions(query, context.world("first"), context.world("second"), context.settings), None


def predict_positions_single_visit(query: Query, context: PredictionContext) -> tuple[UniformPick | UniformBox, None]:
    """Answer as the static arm positions_single_visit: no perception, no grounding."""
    tracks = [instance.track for instance in context.world("second").category(query.category)]
    return pick_instance(query.relation, tracks, context.reachable), None


def answer_positions(query: Query, world_1: WorldState, world_2: WorldState, settings: Settings) -> Answer | Abstention:
    """Answer from the recorded instances of both visits. Identities are not compared across visits.

    settings: association.* and admissibility.tau_m.
    """
    constants = settings.association
    if query.relation is Relation.MOVING:
        return decide_by_spread([k.track for k in world_2.category(query.category)], constants.track_spread_m)
    first = sorted(world_1.category(query.category), key=lambda k: (k.x, k.z))
    second = sorted(world_2.category(query.category), key=lambda k: (k.x, k.z))
    p_1, p_2 = ([(k.x, k.z) for k in instances] for instances in (first, second))
    matched = associate(p_1, p_2, gate_m=constants.gate_m, feature_scale_m=constants.feature_scale_m)
    return decide(query.relation, p_1, p_2, matched, settings.admissibility.tau_m)


# Embodied arms ----------------------------------------------------------------------------------------------------------------


class TwoVisits(GoalAgent):
    """The arm two_visits_embodied. For MOVING it drives to where it saw the target last."""

    def familiarise(self, visit: Visit) -> None:
        """Map the first visit."""
        super().familiarise(visit)
        self.map_1 = ObjectMap.of(self.context.mapper(visit))

    def revisit(self, visit: Visit) -> None:
        """Map the second visit."""
        super().revisit(visit)
        self.map_2 = ObjectMap.of(self.context.mapper(visit))

    def decide(self, query: Query) -> Answer | Abstention:
        """Answer from both maps."""
        phrase = self.context.noun(query.phrase)
        return answer_phrase(query.relation, self.map_1, self.map_2, phrase, self.context.settings)[0]


class SingleVisit(TwoVisits):
    """The arm single_visit_embodied: the reference agent without the first visit. It draws once from its pick."""

    def familiarise(self, visit: Visit) -> None:
        """Keep nothing."""

    def decide(self, query: Query) -> Answer | Abstention:
        """Draw from the pick on the second map."""
        phrase, settings = self.context.noun(query.phrase), self.context.settings
        grounded = ground(self.map_2.f, phrase, settings.grounding.similarity_margin)
        return draw(pick_grounded(query.relation, self.map_2, grounded, self.second.reachable)[0], self.context.rng)


def draw(outcome: UniformPick | UniformBox | Abstention, rng: np.random.Generator) -> Answer | Abstention:
    """Draw once from a pick; an abstention stays one."""
    match outcome:
        case Abstention():
            return outcome
        case UniformPick(candidates):
            return Answer(*candidates[int(rng.integers(len(candidates)))])
        case UniformBox(x_min, z_min, x_max, z_max):
            return Answer(float(rng.uniform(x_min, x_max)), float(rng.uniform(z_min, z_max)))


class PositionsTwoVisits(GoalAgent):
    """The arm two_visits_oracle_positions: association, decision and navigation with true positions."""

    def familiarise(self, visit: Visit) -> None:
        """Keep the places of all instances."""
        self.world_1 = collect_world(visit)

    def revisit(self, visit: Visit) -> None:
        """Keep the places of all instances, and the grid on which to navigate."""
        super().revisit(visit)
        self.world_2 = collect_world(visit)

    def decide(self, query: Query) -> Answer | Abstention:
        """Decide once. The goal of a MOVING query is the instance, for the other relations a point."""
        answer = answer_positions(query, self.world_1, self.world_2, self.context.settings)
        self.follow: str | None = None
        if query.relation is Relation.MOVING and isinstance(answer, Answer):
            at = (answer.x, answer.z)
            self.follow = next(k.id for k in self.world_2.category(query.category) if k.track[-1] == at)
        return answer

    def act(self, observation: Observation) -> Action:
        """Return the next primitive towards the answer or the instance, ABSTAIN without an answer."""
        if isinstance(self.goal, Abstention):
            return Action.ABSTAIN
        return self.context.pilot.act(observation, find_instance(observation, self.follow) or (self.goal.x, self.goal.z))


def collect_world(visit: Visit) -> WorldState:
    """Return the instances of a visit with true positions: last position and track of each."""
    tracks: dict[str, list[tuple[float, float]]] = {}
    categories: Mapping[str, str] = {s.instance: s.category for o in visit.observations for s in o.positions or ()}
    for observation in visit.observations:
        for seen in observation.positions or ():
            tracks.setdefault(seen.instance, []).append((seen.x, seen.z))
    return WorldState(tuple(Instance(k, categories[k], *track[-1], tuple(track)) for k, track in sorted(tracks.items())))
