"""Poses of the agent from which it can interact with an object (AI2-THOR's GetInteractablePoses).

The visible points of an object do not depend on the agent's rotation. So rays are cast once for each position of the camera, and
rotations and horizons only select the rays within the image.
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
"""Number of rays of each position that are tested for a view before all are."""
CONE_MARGIN = 1e-3
"""Margin of the cone around an object, as a cosine: rounding."""
HEMISPHERE = 0.1
"""Cosine of half the opening angle of the widest cone that is cut out of the sphere of directions."""


def ways_to(sight: Sight, instance: int, camera: np.ndarray, distance_m: float) -> np.ndarray:
    """Return unit vectors (K, 3) of all rays from a camera at `camera` (3,) that may hit an instance.

    They are those of `Sight.visible`. The instance is no farther than `distance_m` in plan.
    """
    low, high = sight.lines.corners[instance, [0, -1]]
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
    """Return unit vectors (K, 3) along which `agent` could interact with an instance.

    These are rays that hit it first, no farther than `distance_m` in plan, while a part of it is that near by both visibility
    schemes.
    """
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
    """Yield poses as arguments of TeleportFull, in AI2-THOR's order.

    That is horizons, rotations, standings, positions, the last fastest.

    `positions` (3,) metres are the agent's. `standings` holds None for an agent that cannot crouch, whose poses then have no
    `standing`. The agent does not move.
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
