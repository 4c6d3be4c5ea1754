"""Between what an agent observes (`ovman.agents.interface`) and the dictionary of the environment. Exact in both directions.

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

from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import Any

import numpy as np

from ovman.agents.interface import CameraPose, Observation, Query, Visit
from ovman.gym.spaces import CATEGORIES, REACHABLE, RELATIONS


def encoded(seen: Observation, reachable: np.ndarray, query: Query) -> dict[str, Any]:
    """An observation and the query as a dictionary that shares no memory with them. Without pictures where it has none.

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


def encoded_tour(visit: Visit) -> dict[str, np.ndarray]:
    """The views of a visit under "rgb", "depth" and "pose", one after the other."""
    frames = list(visit.observations)
    return {
        "rgb": np.stack([_there(frame.rgb) for frame in frames]),
        "depth": np.stack([_there(frame.depth) for frame in frames]),
        "pose": np.stack([_numbers(frame.pose) for frame in frames]),
    }


def observation_of(given: Mapping[str, Any], field_of_view_deg: float, looks: bool) -> Observation:
    """What an agent observes. looks: whether it takes images. ValueError where it does and there are none."""
    if looks and "rgb" not in given:
        raise ValueError("the agent takes images and the environment was made without; make it with looks=True")
    return Observation(
        given["rgb"] if looks else None,
        given["depth"] if looks else None,
        CameraPose(*given["pose"].tolist()),
        field_of_view_deg,
        bool(given["last_action_succeeded"]),
        None,
        reachable_of(given) if given["reachable_anew"] else None,
    )


def reachable_of(given: Mapping[str, Any]) -> np.ndarray:
    """The positions (K, 2) that can be reached, metres."""
    positions: np.ndarray = given["reachable"][: given["reachable_count"]]
    return positions


def visit_of(which: str, given: Mapping[str, Any], field_of_view_deg: float, reachable: np.ndarray) -> Visit:
    """The visit "first" or "second". given: an observation, or the information of a reset, that has the tours."""
    shown = [given[f"{which}_{part}"] for part in ("rgb", "depth", "pose")]
    views = zip(*shown[:2], shown[2].tolist(), strict=True)
    frames = tuple(Observation(rgb, depth, CameraPose(*at), field_of_view_deg) for rgb, depth, at in views)
    return Visit(frames, reachable, _digest(field_of_view_deg, shown))


def query_of(given: Mapping[str, Any]) -> Query:
    """What the agent is asked."""
    return Query(CATEGORIES[given["category"]], RELATIONS[given["relation"]])


def _numbers(pose: CameraPose) -> np.ndarray:
    return np.array([pose.x, pose.y, pose.z, pose.yaw_deg, pose.horizon_deg])


def _there(picture: np.ndarray | None) -> np.ndarray:
    assert picture is not None, "a recorded tour has pictures"
    return picture


def _digest(field_of_view_deg: float, shown: Sequence[np.ndarray]) -> str:
    found = sha256(repr(field_of_view_deg).encode())
    for array in shown:
        found.update(np.ascontiguousarray(array).data)
    return found.hexdigest()
