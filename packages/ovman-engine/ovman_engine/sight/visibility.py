"""Which objects the agent sees: near enough, in the picture, and met first by a straight look from the camera.

AI2-THOR casts rays from the camera to points that its artists put on each object. Here looks go along fixed directions all
around the camera and to points spread over the surface of every object that is near, against the triangles that pictures show:
what is visible has pixels, and what has more than a few pixels is visible. The looks of a camera do not depend on which way it
is turned, so that visibility is a property of a pose, however it was come to. Contract, section 2.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from ovman_engine.bodies.body import Agent
from ovman_engine.picture import scene_mesh
from ovman_engine.sight.sightlines import TRANSPARENT, Sightlines

COLLIDER, DISTANCE = "Collider", "Distance"
"""AI2-THOR's visibility schemes: a part of the object within a capsule around the agent that reaches up by the visibility
distance, or a point of it that is seen, within that distance in plan."""
SPACING = 64
"""Directions along the edge of each of six faces of a cube: 1.4 degrees apart, not four pixels of AI2-THOR's pictures."""
ABYSS_M = 100.0
"""By the scheme "Distance" an object may be this far below the agent."""
ROUNDING_M, ROUNDING = 1e-3, 1e-5
"""More than the single precision of distances, and of cosines, can be off."""
POSES_KEPT = 64
"""Ways that a camera looks for which its directions are remembered."""
NEAR_M = 0.1
"""SightRays begin this far from the camera, as pictures do."""


@dataclass(frozen=True)
class Eye:
    """The camera and the agent that carries it."""

    axis: tuple[float, float]
    """Heights of the ends of the axis of the agent's capsule, metres"""
    agent_y: float
    """Height of the agent's position"""
    position: np.ndarray
    """(3,) metres, of the camera, which is above the middle of the agent"""
    yaw_deg: float
    horizon_deg: float
    field_of_view_deg: float
    """vertical"""
    aspect: float
    """width by height"""

    @staticmethod
    def of(agent: Agent, field_of_view_deg: float, aspect: float) -> Eye:
        """The eye of `agent` as it stands."""
        axis, height = agent.embodiment.axis(agent.foot), float(agent.position[1])
        return Eye(axis, height, agent.camera, agent.yaw_deg, agent.horizon_deg, field_of_view_deg, aspect)

    def frames(self, ways: np.ndarray) -> np.ndarray:
        """Which directions (K, 3) lead into the picture: (K,) bool."""
        return in_picture(ways, axes(self.yaw_deg, self.horizon_deg), self.field_of_view_deg, self.aspect)


def axes(yaw_deg: float, horizon_deg: float) -> np.ndarray:
    """Rows right, up, forward of a camera: unit vectors (3, 3)."""
    yaw, pitch = math.radians(yaw_deg), math.radians(horizon_deg)
    sy, cy, sp, cp = math.sin(yaw), math.cos(yaw), math.sin(pitch), math.cos(pitch)
    return np.array([[cy, 0.0, -sy], [sy * sp, cp, cy * sp], [sy * cp, -sp, cy * cp]])


def in_picture(ways: np.ndarray, frame: np.ndarray, field_of_view_deg: float, aspect: float) -> np.ndarray:
    """Which directions (K, 3) lead into the picture of a camera whose axes are the rows of `frame` (3, 3): (K,) bool."""
    right, up, forward = frame.astype(ways.dtype) @ ways.T
    reach = forward * ways.dtype.type(math.tan(math.radians(field_of_view_deg) / 2))
    return (np.abs(up) <= reach) & (np.abs(right) <= reach * ways.dtype.type(aspect)) & (forward > 0)


@cache
def directions() -> np.ndarray:
    """Unit vectors all around, (6 SPACING**2, 3) float32, in squares of neighbours."""
    edge = np.tan((np.arange(SPACING) + 0.5) / SPACING * math.pi / 2 - math.pi / 4)
    blocks = np.arange(SPACING).reshape(-1, 4)
    rows, columns = (np.array([(i, j) for a in blocks for b in blocks for i in a for j in b]).T).tolist()
    face = np.stack([edge[columns], edge[rows], np.ones(SPACING**2)], axis=1)
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    turns = [np.roll(np.eye(3), k, axis=1) * sign for sign in (1.0, -1.0) for k in range(3)]
    found = np.concatenate([face @ turn for turn in turns]).astype(np.float32)
    found.setflags(write=False)
    return found


@lru_cache(maxsize=POSES_KEPT)
def _framed(yaw_deg: float, horizon_deg: float, field_of_view_deg: float, aspect: float) -> np.ndarray:
    """Those of the `directions` that lead into the picture of a camera, (K, 3)."""
    found = directions()[in_picture(directions(), axes(yaw_deg, horizon_deg), field_of_view_deg, aspect)]
    found.setflags(write=False)
    return found


def toward(points: np.ndarray, camera: np.ndarray) -> np.ndarray:
    """Unit vectors (K, 3) float32 from a camera (3,) to points (K, 3)."""
    to = points - camera.astype(np.float32)
    return to / np.maximum(np.sqrt(np.einsum("ki,ki->k", to, to)), np.float32(1e-9))[:, None]


@dataclass(frozen=True)
class SightRays:
    """K looks from one camera."""

    ways: np.ndarray
    """(K, 3) unit vectors, float32"""
    first: np.ndarray
    """(K,) int, the instance that each meets first; negative: none"""
    behind: np.ndarray
    """(K,) int, the first that is not transparent"""
    away_m: np.ndarray
    """(2, K) how far from the camera each meets `first` and `behind`"""

    def within(self, k: int, camera_m: float, distance_m: float) -> np.ndarray:
        """(K,) bool: looks that meet something (0: first, 1: behind what is transparent) within the distance in plan, and not
        farther above the agent, whose camera is `camera_m` above its position."""
        plan = self.away_m[k] * np.hypot(self.ways[:, 0], self.ways[:, 2])
        return (plan <= distance_m) & (self.away_m[k] * self.ways[:, 1] + camera_m <= distance_m)


def _tall(axis: tuple[float, float], distance_m: float, scheme: str) -> tuple[float, float]:
    """Heights between which the axis of the capsule around the agent runs that a visible object reaches into."""
    return (axis[0] if scheme == COLLIDER else axis[0] - ABYSS_M), axis[1] + distance_m


@dataclass(frozen=True)
class Spheres:
    """Spheres that N bodies lie in, with the boxes of their parts. Nothing is needed for them that a movement makes stale."""

    centres: np.ndarray
    """(N, 3) metres"""
    radii: np.ndarray
    """(N,) metres"""

    @staticmethod
    def around(world, names: Collection[str]) -> Spheres:
        """Those of the bodies of these names that there are."""
        meshes = scene_mesh.of_plan(world.plan, world.room)
        bodies = [world.bodies[name] for name in sorted(names) if name in world.bodies]
        radii = np.array([meshes.radius_m(body.obj.object_id) + ROUNDING_M for body in bodies])
        return Spheres(np.array([body.box.centre for body in bodies]).reshape(-1, 3), radii)

    def within(self, eye: Eye, distance_m: float) -> Spheres:
        """Without those that are too far away in plan for their bodies to be visible (`Sight.near`)."""
        away_m = np.hypot(*(self.centres - eye.position)[:, [0, 2]].T)
        near = away_m <= distance_m + self.radii
        return Spheres(self.centres[near], self.radii[near])

    def met(self, eye: Eye, ways: np.ndarray) -> np.ndarray:
        """Which looks along unit vectors (K, 3) may meet one of them: (K,) bool."""
        to = self.centres - eye.position
        away_m = np.linalg.norm(to, axis=1)
        met = np.zeros(len(ways), bool)
        for way, far_m, radius_m in zip(to, away_m, self.radii, strict=True):
            if far_m <= radius_m:
                return np.ones(len(ways), bool)
            met |= ways @ (way / far_m).astype(ways.dtype) >= math.sqrt(1.0 - (radius_m / far_m) ** 2) - ROUNDING
        return met


class Sight:
    """Who is visible in a world as it is at one moment."""

    def __init__(self, world) -> None:
        self.lines = Sightlines(world)
        bodies = world.bodies
        kinds = {name: body.obj.type for name, body in bodies.items()}
        self._transparent = np.array([kinds.get(name) in TRANSPARENT for name in self.lines.names])
        self._opaque = np.zeros_like(self._transparent)

    def visible(
        self, eye: Eye, distance_m: float, scheme: str = COLLIDER, towards: Spheres | None = None
    ) -> tuple[set[str], set[str]]:
        """Names of the instances that are visible, and of those of them that are interactable; of all, or at least of those whose
        spheres are given."""
        near = self.near(eye, distance_m, scheme)
        if not near.any():
            return set(), set()
        targets = self.lines.points[near].reshape(-1, 3)
        ways = toward(targets[np.isfinite(targets[:, 0])], eye.position)
        ways = np.concatenate([_framed(eye.yaw_deg, eye.horizon_deg, eye.field_of_view_deg, eye.aspect), ways[eye.frames(ways)]])
        if towards is not None:
            ways = ways[towards.met(eye, ways)]
        looks = self.look(eye.position, ways)
        seen = []
        for k, owner in enumerate((looks.first, looks.behind)):
            hit = looks.within(k, eye.position[1] - eye.agent_y, distance_m) if scheme == DISTANCE else owner >= 0
            found = np.unique(owner[hit & (owner >= 0)])
            seen.append({self.lines.names[i] for i in found[near[found]]})
        return seen[0] | seen[1], seen[0]

    def near(self, eye: Eye, distance_m: float, scheme: str = COLLIDER) -> np.ndarray:
        """(N,) bool: instances of which a part is near enough to be visible."""
        low, high = _tall(eye.axis, distance_m, scheme)
        return self.lines.distances(float(eye.position[0]), float(eye.position[2]), low, high) <= distance_m

    def near_one(
        self, instance: int, camera: np.ndarray, axis: tuple[float, float], distance_m: float, scheme: str = COLLIDER
    ) -> bool:
        """Whether one instance is near enough to be visible from a camera at `camera` (3,); see `Eye.axis`."""
        low, high = _tall(axis, distance_m, scheme)
        return self.lines.distance(instance, float(camera[0]), float(camera[2]), low, high) <= distance_m

    def look(self, position: np.ndarray, ways: np.ndarray) -> SightRays:
        """What looks from a camera at `position` (3,) along unit vectors (K, 3) meet."""
        ways = np.ascontiguousarray(ways, dtype=np.float32)
        origins = position.astype(np.float32) + np.float32(NEAR_M) * ways
        first, distance = self.lines.first(origins, ways, self._opaque)
        behind, further = first.copy(), distance.copy()
        glass = np.flatnonzero(np.append(self._transparent, [False, False])[first])
        if len(glass):
            start = origins[glass] + ways[glass] * distance[glass][:, None]
            behind[glass], beyond = self.lines.first(start, ways[glass], self._transparent)
            further[glass] += beyond
        return SightRays(ways, first, behind, np.stack([distance, further]) + np.float32(NEAR_M))
