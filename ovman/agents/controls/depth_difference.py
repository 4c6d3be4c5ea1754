"""The control that looks at depth alone: something stands where a camera of the other tour looked through."""

from __future__ import annotations

import numpy as np

from ovman.agents.answered import Driver, driver
from ovman.agents.controls.difference import DifferenceAgent, answer
from ovman.agents.controls.samples import Shown
from ovman.agents.interface import Abstention, AgentContext, Answer, PredictionContext, Query
from ovman.settings import Settings


def nearer(shown: Shown, settings: Settings) -> np.ndarray:
    """By how much (k,) metres more than controls.changed_m the other frame sees beyond the places of a frame.

    NaN where it sees something before them, by more than that.
    """
    beyond = shown.depth - shown.away
    votes: np.ndarray = np.where(beyond < -settings.controls.changed_m, np.nan, beyond - settings.controls.changed_m)
    return votes


def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arm."""
    return answer(query.relation.past, context.tour("first"), context.tour("second"), nearer, context.settings), None


def agent(context: AgentContext) -> Driver | DifferenceAgent:
    """The embodied arm."""
    return driver(context) or DifferenceAgent(context.pilot, nearer, context.settings)
