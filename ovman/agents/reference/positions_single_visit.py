"""The diagnostic of the single-visit baseline with true positions: no perception, no grounding."""

from __future__ import annotations

from ovman.agents.interface import PredictionContext, Query, UniformBox, UniformPick
from ovman.agents.reference.reasoning import single_visit_pick


def predict(query: Query, context: PredictionContext) -> tuple[UniformPick | UniformBox, None]:
    """The static arm positions_single_visit."""
    tracks = [instance.track for instance in context.world("second").category(query.category)]
    return single_visit_pick(query.relation, tracks, context.reachable), None
