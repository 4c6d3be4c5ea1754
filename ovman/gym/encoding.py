"""Observations of agents (`ovman.agents.interface`) as dictionaries of the environment.

| key | |
| --- | --- |
| rgb | (H, W, 3) uint8 |
| depth | (H, W) float32, metres along the optical axis |
| pose | (5,) float64: the camera's x, y, z in metres, yaw and horizon in degrees |
| last_action_succeeded | 0 where the last move was blocked |
| reachable | (REACHABLE, 2) float64: the positions that can be reached now, metres; zeros after the first reachable_count |
| reachable_count | how many |
| reachable_anew | 1 where the positions were found anew for this observation, since something has moved (MOVING) |
| relation | the number of the query's relation in RELATIONS |
| category | the number of the query's category in CATEGORIES |
| first_rgb, first_depth, first_pose | the views of the first tour, one after the other |
| second_rgb, second_depth, second_pose | those of the second |
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ovman.agents.interface import CameraPose, Observation, Query, Visit
from ovman.gym.spaces import CATEGORIES, REACHABLE, RELATIONS


def encode_observation(seen: Observation, reachable: np.ndarray, query: Query) -> dict[str, Any]:
    """Return an observation and the query as a dictionary that shares no memory with them; without pictures if it has none.

    reachable: (K, 2), the positions that hold now. ValueError for more than REACHABLE.
    """
    if len(reachable) > REACHABLE:
        raise ValueError(f"{len(reachable)} positions can be reached, and an observation holds {REACHABLE}; raise REACHABLE")
    positions = np.zeros((REACHABLE, 2))
    positions[: len(reachable)] = reachable
    pictures = {} if seen.rgb is None or seen.depth is None else {"rgb": seen.rgb.copy(), "depth": seen.depth.copy()}
    return pictures | {
        "pose": _numbers(seen.pose),
        "last_action_succeeded": int(seen.last_action_succeeded),
        "reachable": positions,
        "reachable_count": len(reachable),
        "reachable_anew": int(seen.reachable is not None),
        "relation": RELATIONS.index(query.relation),
        "category": CATEGORIES.index(query.category),
    }


def encode_tour(visit: Visit) -> dict[str, np.ndarray]:
    """Return the views of a visit under "rgb", "depth" and "pose", one after the other."""
    frames = list(visit.observations)  # each is read from its files when it is indexed
    return {
        "rgb": np.stack([frame.rgb for frame in frames if frame.rgb is not None]),
        "depth": np.stack([frame.depth for frame in frames if frame.depth is not None]),
        "pose": np.stack([_numbers(frame.pose) for frame in frames]),
    }


def _numbers(pose: CameraPose) -> np.ndarray:
    return np.array([pose.x, pose.y, pose.z, pose.yaw_deg, pose.horizon_deg])
