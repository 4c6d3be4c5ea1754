"""The control that looks at depth alone: something stands nearer in one tour than the other tour shows from there."""

from __future__ import annotations

import numpy as np

from ovman.agents.controls.difference import DifferenceAgent, answer
from ovman.agents.controls.samples import Sample, Shown
from ovman.agents.interface import Abstention, AgentContext, Answer, PredictionContext, Query
from ovman.models.settings import Settings


def nearer(sample: Sample, shown: Shown, settings: Settings) -> np.ndarray:
    """Cells (h, w) of a frame whose depth is less than the other tour's by more than controls.changed_m."""
    cells: np.ndarray = shown.depth - sample.depth > settings.controls.changed_m
    return cells


def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arm."""
    return answer(query.relation.past, context.tour("first"), context.tour("second"), nearer, context.settings), None


def agent(context: AgentContext) -> DifferenceAgent:
    """The embodied arm."""
    return DifferenceAgent(context.pilot, nearer, context.settings)
