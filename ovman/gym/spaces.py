"""The spaces of the environment and its observations: fixed shapes, finite bounds, numbers alone, no nested dictionary.

| key | |
| --- | --- |
| rgb | (H, W, 3) uint8 |
| depth | (H, W) float32, metres along the optical axis |
| pose | (5,) float64: the camera's x, y, z in metres, yaw and horizon in degrees |
| last_action_succeeded | 0 where the last move was blocked |
| reachable | (REACHABLE, 2) float64: the positions that can be reached now, metres; zeros after the first reachable_count |
| reachable_count | how many |
| reachable_anew | 1 where the positions were computed again for this observation, since something has moved (MOVING) |
| relation | the number of the query's relation in RELATIONS; not in the words track |
| category | the number of the query's category in CATEGORIES; not in the words track |
| first_rgb, first_depth, first_pose | the views of the first tour, one after the other; a shorter tour repeats its last view |
| second_rgb, second_depth, second_pose | the views of the second tour |

Some libraries read no nested one, and none of Gymnasium 1.4.0's texts comes through the memory that its processes share: it is
read once, before the first reset. So sentence and phrase, of the space INSTRUCTION, are in the information of `reset`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces

from ovman.agents.interface import VISITS, Action, CameraPose, Instruction, Observation, Query, Relation, Visit
from ovman.language.vocabulary import SYNONYMS
from ovman.settings.arms import Track
from ovman.settings.benchmark import Camera
from ovman.sim.sensing import FARTHEST_M

ACTIONS = tuple(Action)
"""The primitives by the numbers of the action space."""
RELATIONS = tuple(Relation)
"""The relations by their numbers in an observation."""
FARTHEST_POSITION_M = 1000.0
"""Bound of every coordinate; homes are a hundred times smaller."""
REACHABLE = 1024
"""Rows of `reachable`; the largest floor plan has fewer than half as many positions."""
PRINTABLE = frozenset(chr(code) for code in range(32, 0x250) if chr(code).isprintable())
"""Characters of a sentence: those of languages in Latin letters."""
CATEGORIES = tuple(SYNONYMS)
"""The categories by their numbers in an observation: the vocabulary of the benchmark."""

INSTRUCTION = spaces.Dict({name: spaces.Text(300, min_length=0, charset=PRINTABLE) for name in ("sentence", "phrase")})
"""The space of the words of a query, in both tracks."""


def action_space() -> spaces.Discrete:
    """Return the space of actions: the number of a primitive in `ACTIONS`."""
    return spaces.Discrete(len(ACTIONS))


def observation_space(camera: Camera, looks: bool, views: int, track: str = Track.PAPER) -> spaces.Dict:
    """Return the space of an observation with the keys of this module's table.

    looks: whether there are pictures where the agent stands. views: number of views of each tour; 0 for no tours.
    """
    high = np.array([FARTHEST_POSITION_M] * 3 + [360.0, 90.0])  # x, y, z in metres, yaw and horizon in degrees
    low = high * [-1, -1, -1, 0, -1]
    found: dict[str, spaces.Space[Any]] = _pictures(camera) if looks else {}
    found |= {
        "pose": spaces.Box(low, high, dtype=np.float64),
        "last_action_succeeded": spaces.Discrete(2),
        "reachable": _uniform(-FARTHEST_POSITION_M, FARTHEST_POSITION_M, (REACHABLE, 2), np.float64),
        "reachable_count": spaces.Discrete(REACHABLE + 1),
        "reachable_anew": spaces.Discrete(2),
    }
    if track == Track.PAPER:
        found |= {"relation": spaces.Discrete(len(RELATIONS)), "category": spaces.Discrete(len(CATEGORIES))}
    for which in VISITS if views else ():
        poses = spaces.Box(np.tile(low, (views, 1)), np.tile(high, (views, 1)), dtype=np.float64)
        found |= {f"{which}_{name}": space for name, space in (_pictures(camera, views) | {"pose": poses}).items()}
    return spaces.Dict(found)


def _pictures(camera: Camera, *views: int) -> dict[str, spaces.Space[Any]]:
    size = (*views, camera.height_px, camera.width_px)
    return {"rgb": _uniform(0, 255, (*size, 3), np.uint8), "depth": _uniform(0.0, FARTHEST_M, size, np.float32)}


def _uniform(low: float, high: float, shape: tuple[int, ...], dtype: Any) -> spaces.Box:
    box = spaces.Box(low, high, shape, dtype)
    # A Box keeps its bounds for every number: 95 MB for two tours, the same value in all of it.
    for name in ("low", "high", "bounded_below", "bounded_above"):
        bound: np.ndarray = getattr(box, name)
        setattr(box, name, np.broadcast_to(bound.flat[0], shape))
    return box


def encode_observation(seen: Observation, reachable: np.ndarray, query: Instruction) -> dict[str, Any]:
    """Return an observation and the query as a dictionary that shares no memory with them; without pictures if it has none.

    reachable: (K, 2), the positions that hold now. ValueError for more than REACHABLE.
    """
    if len(reachable) > REACHABLE:
        raise ValueError(f"{len(reachable)} positions can be reached, and an observation holds {REACHABLE}; raise REACHABLE")
    positions = np.zeros((REACHABLE, 2))
    positions[: len(reachable)] = reachable
    pictures = {} if seen.rgb is None or seen.depth is None else {"rgb": seen.rgb.copy(), "depth": seen.depth.copy()}
    known = {}
    if isinstance(query, Query):
        known = {"relation": RELATIONS.index(query.relation), "category": CATEGORIES.index(query.category)}
    return pictures | {
        "pose": _numbers(seen.pose),
        "last_action_succeeded": int(seen.last_action_succeeded),
        "reachable": positions,
        "reachable_count": len(reachable),
        "reachable_anew": int(seen.reachable is not None),
        **known,
    }


def encode_tour(visit: Visit, views: int) -> dict[str, np.ndarray]:
    """Return the views of a visit under "rgb", "depth" and "pose", one after the other, the last repeated up to `views`."""
    frames = list(visit.observations)  # each is read from its files when it is indexed
    frames += frames[-1:] * (views - len(frames))
    return {
        "rgb": np.stack([frame.rgb for frame in frames if frame.rgb is not None]),
        "depth": np.stack([frame.depth for frame in frames if frame.depth is not None]),
        "pose": np.stack([_numbers(frame.pose) for frame in frames]),
    }


def _numbers(pose: CameraPose) -> np.ndarray:
    return np.array([pose.x, pose.y, pose.z, pose.yaw_deg, pose.horizon_deg])
