"""What the evaluator says to an agent in a process of its own (docs/protocol.md): observations and the query, no more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ovman.agents.interface import Observation, Query, Visit
from ovman.runner import AGENT_DRAWS, Run
from ovman_client.messages import PICTURES, POSE, POSITIONS


def begin(run: Run) -> dict[str, Any]:
    """The message `begin`: constants of the protocol, the body's camera, and words from which the agent's draws follow."""
    body, primitives = run.embodiment, run.episode.protocol.primitives
    budget = primitives.action_budget if run.arm.budget is None else run.arm.budget
    return {
        "type": "begin",
        **primitives.model_dump(mode="json"),
        "action_budget": budget,
        "camera": {"width": body.width_px, "height": body.height_px, "field_of_view_deg": body.field_of_view_deg},
        "words": {name: run.words(name) for name in AGENT_DRAWS},
    }


def visit(made: Visit, observations: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """A visit in a message; observations: of it, as `observation` makes them."""
    return {"observations": list(observations), "reachable": _array(made.reachable, POSITIONS), "content": made.content}


def observation(seen: Observation) -> dict[str, Any]:
    """An observation in a message. ValueError for one with positions, which no agent in a process of its own is given."""
    if seen.positions is not None:
        raise ValueError("an agent that is given positions runs in the evaluator's process")
    return {
        "rgb": None if seen.rgb is None else _array(seen.rgb, PICTURES["rgb"]),
        "depth": None if seen.depth is None else _array(seen.depth, PICTURES["depth"]),
        "pose": {name: float(getattr(seen.pose, name)) for name in POSE},
        "field_of_view_deg": float(seen.field_of_view_deg),
        "last_action_succeeded": bool(seen.last_action_succeeded),
        "reachable": None if seen.reachable is None else _array(seen.reachable, POSITIONS),
    }


def query(asked: Query) -> dict[str, Any]:
    """The query in a message."""
    return {"category": asked.category, "relation": str(asked.relation)}


def _array(values: np.ndarray, dtype: str) -> dict[str, Any]:
    ordered = np.ascontiguousarray(values, dtype)
    return {"dtype": dtype, "shape": list(ordered.shape), "data": ordered.tobytes()}
