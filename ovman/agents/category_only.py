"""Who recognises the category and ignores the relation: the shortcut that the benchmark has to keep at chance 1/n.

Positions are true, so that nothing but the choice of the instance is left to chance.
"""

from __future__ import annotations

from ovman.agents.interface import PredictionContext, Query, UniformPick


def predict_answers_visit(query: Query, context: PredictionContext) -> tuple[UniformPick, None]:
    """Any instance of the category that was recorded in the visit that the answer belongs to, each as likely."""
    return _any_instance(query, context, "first" if query.relation.past else "second")


def predict_second_visit(query: Query, context: PredictionContext) -> tuple[UniformPick, None]:
    """Any instance of the category that was recorded in the second visit, each as likely; where it moved, its last position."""
    return _any_instance(query, context, "second")


def _any_instance(query: Query, context: PredictionContext, which: str) -> tuple[UniformPick, None]:
    return UniformPick(tuple(instance.position for instance in context.world(which).category(query.category))), None
