"""The control that looks at colour alone. Depth places what differs, and carries pictures to other cameras; it decides nothing.

Colours do not say which of the tours shows the object and which the background: a displaced object differs at both of its places.
"""

from __future__ import annotations

import numpy as np

from ovman.agents.controls.difference import DifferenceAgent, answer
from ovman.agents.controls.samples import Sample, Shown
from ovman.agents.interface import Abstention, AgentContext, Answer, PredictionContext, Query
from ovman.models.settings import Settings


def discoloured(sample: Sample, shown: Shown, settings: Settings) -> np.ndarray:
    """Cells (h, w) of a frame of which a colour channel is outside the other tour's bounds by more than controls.changed_level."""
    beyond = np.maximum(shown.darkest - sample.rgb, sample.rgb - shown.lightest).max(axis=2)
    cells: np.ndarray = beyond > settings.controls.changed_level
    return cells


def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arm."""
    return answer(query.relation.past, context.tour("first"), context.tour("second"), discoloured, context.settings), None


def agent(context: AgentContext) -> DifferenceAgent:
    """The embodied arm."""
    return DifferenceAgent(context.pilot, discoloured, context.settings)
