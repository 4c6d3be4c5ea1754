"""The control that looks at colour alone. Depth places what differs, and says which pixels of other cameras look at a place.

From equal poses depth decides nothing, and colours do not say which of the tours shows the object and which the background: a
displaced object differs at both of its places.
"""

from __future__ import annotations

import numpy as np

from ovman.agents.answered import Driver, driver
from ovman.agents.controls.difference import DifferenceAgent, answer
from ovman.agents.controls.samples import Shown
from ovman.agents.interface import Abstention, AgentContext, Answer, PredictionContext, Query
from ovman.settings import Settings


def discoloured(shown: Shown, settings: Settings) -> np.ndarray:
    """By how much (k,) more than controls.changed_level a channel of a frame is beyond the other's bounds; full scale is 1."""
    darkest, lightest = shown.colours()
    own = shown.own()
    red, green, blue = np.maximum(darkest - own, own - lightest).T
    votes: np.ndarray = np.maximum(np.maximum(red, green), blue) - settings.controls.changed_level
    return votes


def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """The static arm."""
    return answer(query.relation.past, context.tour("first"), context.tour("second"), discoloured, context.settings), None


def agent(context: AgentContext) -> Driver | DifferenceAgent:
    """The embodied arm."""
    return driver(context) or DifferenceAgent(context.pilot, discoloured, context.settings)
