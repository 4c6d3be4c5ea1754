"""The spaces of the environment: fixed shapes, finite bounds, numbers alone, no nested dictionary.

Some libraries read no nested one, and none of Gymnasium 1.4.0's texts comes through the memory that its processes share: it is
read once, before the first reset.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces

from ovman.agents.interface import VISITS, Action, Relation
from ovman.language.vocabulary import SYNONYMS
from ovman.records.episode import Episode
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
CATEGORIES = tuple(SYNONYMS)
"""The categories by their numbers in an observation: the vocabulary of the benchmark."""


def action_space() -> spaces.Discrete:
    """Return the space of actions: the number of a primitive in `ACTIONS`."""
    return spaces.Discrete(len(ACTIONS))


def observation_space(episode: Episode, looks: bool, tours: bool) -> spaces.Dict:
    """Return the space of an observation of episodes like this one, with the keys of `ovman.gym.encoding`.

    looks: whether there are pictures where the agent stands. tours: whether there are both tours.
    """
    camera, tour = episode.protocol.camera, episode.tours.first
    views = len(tour.waypoints) * tour.headings
    high = np.array([FARTHEST_POSITION_M] * 3 + [360.0, 90.0])  # x, y, z in metres, yaw and horizon in degrees
    low = high * [-1, -1, -1, 0, -1]
    found: dict[str, spaces.Space[Any]] = _pictures(camera) if looks else {}
    found |= {
        "pose": spaces.Box(low, high, dtype=np.float64),
        "last_action_succeeded": spaces.Discrete(2),
        "reachable": _uniform(-FARTHEST_POSITION_M, FARTHEST_POSITION_M, (REACHABLE, 2), np.float64),
        "reachable_count": spaces.Discrete(REACHABLE + 1),
        "reachable_anew": spaces.Discrete(2),
        "relation": spaces.Discrete(len(RELATIONS)),
        "category": spaces.Discrete(len(CATEGORIES)),
    }
    for which in VISITS if tours else ():
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
