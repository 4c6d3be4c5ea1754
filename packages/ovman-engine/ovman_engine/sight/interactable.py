"""Poses of the agent from which an object is visible and can be reached (AI2-THOR's GetInteractablePoses).

What can be seen of an object from a place does not depend on the agent's rotation: looks are cast once for each place of the
camera, and rotations and horizons only choose those of them that lead into the picture.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ovman_engine.bodies.body import Agent
from ovman_engine.sight.visibility import COLLIDER, Sight, axes, directions, in_picture, toward

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
ROUNDING_M = 1e-6
FEW = 32
"""SightRays of each place that are tried for a view before all are."""
CONE_MARGIN = 1e-3
"""Directions this far outside the cone around an object, as a cosine, are looked along too: rounding."""
HEMISPHERE = 0.1
"""Cosine of half the opening of the widest cone that a narrower one is told from the whole sphere."""


def ways_to(sight: Sight, instance: int, camera: np.ndarray, distance_m: float) -> np.ndarray:
    """Unit vectors (K, 3) of all looks from a camera at `camera` (3,) that may meet an instance no farther than `distance_m` in
    plan: those of `Sight.visible`."""
    low, high = sight.lines.bounds(instance)
    reach = np.array([distance_m, np.inf, distance_m]) + ROUNDING_M
    low, high = np.maximum(low, camera - reach), np.minimum(high, camera + reach)
    ways = directions()
    if ((low > camera) | (high < camera)).any():
        around = CORNERS * (high - low) + low - camera
        around /= np.maximum(np.linalg.norm(around, axis=1, keepdims=True), ROUNDING_M)
        middle = around.mean(axis=0)
        middle /= max(float(np.linalg.norm(middle)), ROUNDING_M)
        narrowest = float((around @ middle).min()) - CONE_MARGIN
        if narrowest > HEMISPHERE:
            ways = ways[ways @ middle > narrowest]
    return np.concatenate([ways, toward(sight.lines.points[instance], camera)])


def reaching(sight: Sight, name: str, agent: Agent, distance_m: float) -> np.ndarray:
    """Unit vectors (K, 3) along which `agent` could reach an instance if it looked that way: looks that meet it first, not
    farther than `distance_m` in plan, while a part of it is so near by both visibility schemes."""
    nowhere = np.zeros((0, 3), dtype=np.float32)
    instance = sight.lines.index.get(name)
    if instance is None or not np.isfinite(sight.lines.points[instance, 0, 0]):
        return nowhere
    camera, low_high = agent.camera, agent.embodiment.axis(agent.foot)
    if not sight.near_one(instance, camera, low_high, distance_m, COLLIDER):
        return nowhere
    looks = sight.look(camera, ways_to(sight, instance, camera, distance_m))
    found = (looks.first == instance) & looks.within(0, float(camera[1] - agent.position[1]), distance_m)
    return looks.ways[found]


def poses(
    sight: Sight,
    name: str,
    agent: Agent,
    positions: Sequence[np.ndarray],
    rotations: Sequence[float],
    horizons: Sequence[float],
    standings: Sequence[bool | None],
    distance_m: float,
    field_of_view_deg: float,
    aspect: float,
) -> Iterator[dict[str, Any]]:
    """Poses as arguments of TeleportFull, in AI2-THOR's order: horizons, rotations, standings, positions, the last fastest.

    `positions` (3,) metres of the agent; `standings` hold None for an agent that neither stands nor crouches, whose poses do not
    tell. The agent stays where it is.
    """
    cameras = [(p, s) for s in standings for p in positions]
    seen = [
        reaching(sight, name, replace(agent, position=np.array(p, dtype=float), standing=s is not False), distance_m)
        for p, s in cameras
    ]
    kept = [k for k in range(len(cameras)) if len(seen[k])]
    if not kept:
        return
    few = np.concatenate([seen[k][:: len(seen[k]) // FEW + 1] for k in kept])
    starts = np.cumsum([0] + [-(-len(seen[k]) // (len(seen[k]) // FEW + 1)) for k in kept[:-1]])
    for horizon in horizons:
        for rotation in rotations:
            frame = axes(rotation, horizon)
            shown = np.logical_or.reduceat(in_picture(few, frame, field_of_view_deg, aspect), starts)
            for k, at_once in zip(kept, shown, strict=True):
                if at_once or in_picture(seen[k], frame, field_of_view_deg, aspect).any():
                    position, standing = cameras[k]
                    pose = dict(zip("xyz", (float(v) for v in position), strict=True))
                    pose |= {"rotation": rotation, "horizon": horizon}
                    yield pose if standing is None else pose | {"standing": standing}
