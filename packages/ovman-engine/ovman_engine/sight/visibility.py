"""Which objects are visible: near enough, within the image, and first on a ray from the camera.

AI2-THOR casts rays from the camera to points that its artists put on each object. Here rays go in fixed directions all around the
camera, and to points spread over the surface of every near object, against the triangles of the images. So a visible object has
pixels, and an object with more than a few pixels is visible. The rays do not depend on the camera's rotation, so visibility is a
function of the pose. Contract, section 2.
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
"""AI2-THOR's visibility schemes. Collider: a part of the object is in a capsule around the agent that extends upwards by the
visibility distance. Distance: a visible point of it is within that distance in plan."""
SPACING = 64
"""Directions along the edge of each of the six faces of a cube: 1.4 degrees apart, less than four pixels of AI2-THOR's images."""
ABYSS_M = 100.0
"""How far below the agent an object may be by the scheme "Distance"."""
ROUNDING_M, ROUNDING = 1e-3, 1e-5
"""Upper bounds on the rounding of distances and cosines in single precision."""
ROUGHLY = 16
"""One in so many directions is looked along first."""
POSES_KEPT = 64
"""Number of camera rotations whose directions are cached."""
NEAR_M = 0.1
"""Rays begin this far from the camera, as those of images do."""


@dataclass(frozen=True)
class Eye:
    """The camera, and the agent that carries it."""

    axis: tuple[float, float]
    """Heights of the ends of the capsule's axis, metres"""
    agent_y: float
    """Height of the agent's position, metres"""
    position: np.ndarray
    """(3,) position of the camera, metres, above the agent's centre"""
    yaw_deg: float
    horizon_deg: float
    field_of_view_deg: float
    """Vertical"""
    aspect: float
    """Width over height"""

    @staticmethod
    def of(agent: Agent, field_of_view_deg: float, aspect: float) -> Eye:
        """Return the eye of `agent` at its current pose."""
        axis, height = agent.embodiment.axis(agent.foot), float(agent.position[1])
        return Eye(axis, height, agent.camera, agent.yaw_deg, agent.horizon_deg, field_of_view_deg, aspect)

    def frames(self, ways: np.ndarray) -> np.ndarray:
        """(K,) bool: which directions (K, 3) are within the image."""
        return in_picture(ways, axes(self.yaw_deg, self.horizon_deg), self.field_of_view_deg, self.aspect)


def axes(yaw_deg: float, horizon_deg: float) -> np.ndarray:
    """Return unit vectors (3, 3) of a camera, in rows: right, up, forward."""
    yaw, pitch = math.radians(yaw_deg), math.radians(horizon_deg)
    sy, cy, sp, cp = math.sin(yaw), math.cos(yaw), math.sin(pitch), math.cos(pitch)
    return np.array([[cy, 0.0, -sy], [sy * sp, cp, cy * sp], [sy * cp, -sp, cy * cp]])


def in_picture(ways: np.ndarray, frame: np.ndarray, field_of_view_deg: float, aspect: float) -> np.ndarray:
    """(K,) bool: which directions (K, 3) are within the image of a camera whose axes are the rows of `frame` (3, 3)."""
    right, up, forward = frame.astype(ways.dtype) @ ways.T
    reach = forward * ways.dtype.type(math.tan(math.radians(field_of_view_deg) / 2))
    return (np.abs(up) <= reach) & (np.abs(right) <= reach * ways.dtype.type(aspect)) & (forward > 0)


@cache
def directions() -> np.ndarray:
    """Return unit vectors in all directions, (6 SPACING**2, 3) float32, in squares of neighbours."""
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
    """Return the `directions` within the image of a camera, (K, 3)."""
    found = directions()[in_picture(directions(), axes(yaw_deg, horizon_deg), field_of_view_deg, aspect)]
    found.setflags(write=False)
    return found


def toward(points: np.ndarray, camera: np.ndarray) -> np.ndarray:
    """Return unit vectors (K, 3) float32 from a camera (3,) to points (K, 3)."""
    to = points - camera.astype(np.float32)
    return to / np.maximum(np.sqrt(np.einsum("ki,ki->k", to, to)), np.float32(1e-9))[:, None]


@dataclass(frozen=True)
class SightRays:
    """The hits of K rays from one camera."""

    ways: np.ndarray
    """(K, 3) unit vectors, float32"""
    first: np.ndarray
    """(K,) int: the first instance on each ray; negative without a hit"""
    behind: np.ndarray
    """(K,) int: the first instance that is not transparent"""
    away_m: np.ndarray
    """(2, K) distances of `first` and `behind` from the camera, metres"""

    def within(self, k: int, camera_m: float, distance_m: float) -> np.ndarray:
        """Return which rays (K,) bool hit within the distance in plan, and at most this far above the agent.

        Hit 0 is the first, 1 the one behind. `camera_m` is the height of the camera above the agent's position.
        """
        plan = self.away_m[k] * np.hypot(self.ways[:, 0], self.ways[:, 2])
        return (plan <= distance_m) & (self.away_m[k] * self.ways[:, 1] + camera_m <= distance_m)


def _tall(axis: tuple[float, float], distance_m: float, scheme: str) -> tuple[float, float]:
    """Heights between which a visible object reaches the axis of the capsule around the agent."""
    return (axis[0] if scheme == COLLIDER else axis[0] - ABYSS_M), axis[1] + distance_m


@dataclass(frozen=True)
class Spheres:
    """Spheres around N bodies and the boxes of their parts. They stay valid when other bodies move."""

    centres: np.ndarray
    """(N, 3) metres"""
    radii: np.ndarray
    """(N,) metres"""

    @staticmethod
    def around(world, names: Collection[str]) -> Spheres:
        """Return the spheres of the named bodies that exist."""
        meshes = scene_mesh.of_plan(world.plan, world.room)
        bodies = [world.bodies[name] for name in sorted(names) if name in world.bodies]
        radii = np.array([meshes.radius_m(body.obj.object_id) + ROUNDING_M for body in bodies])
        return Spheres(np.array([body.box.centre for body in bodies]).reshape(-1, 3), radii)

    def within(self, eye: Eye, distance_m: float) -> Spheres:
        """Return the spheres without bodies that are too far away in plan to be visible (`Sight.near`)."""
        away_m = np.hypot(*(self.centres - eye.position)[:, [0, 2]].T)
        near = away_m <= distance_m + self.radii
        return Spheres(self.centres[near], self.radii[near])

    def met(self, eye: Eye, ways: np.ndarray) -> np.ndarray:
        """(K,) bool: which rays along unit vectors (K, 3) may hit a sphere."""
        to = self.centres - eye.position
        away_m = np.linalg.norm(to, axis=1)
        met = np.zeros(len(ways), bool)
        for way, far_m, radius_m in zip(to, away_m, self.radii, strict=True):
            if far_m <= radius_m:
                return np.ones(len(ways), bool)
            met |= ways @ (way / far_m).astype(ways.dtype) >= math.sqrt(1.0 - (radius_m / far_m) ** 2) - ROUNDING
        return met


class Sight:
    """Visibility in the current state of a world."""

    def __init__(self, world) -> None:
        """Follows no later change of `world`."""
        self.lines = Sightlines(world)
        bodies = world.bodies
        kinds = {name: body.obj.type for name, body in bodies.items()}
        self._transparent = np.array([kinds.get(name) in TRANSPARENT for name in self.lines.names])
        self._opaque = np.zeros_like(self._transparent)
        self._objects = np.array([name in bodies for name in self.lines.names])

    def visible(
        self, eye: Eye, distance_m: float, scheme: str = COLLIDER, towards: Spheres | None = None
    ) -> tuple[set[str], set[str]]:
        """Names of the visible instances, and of the interactable ones among them. Of structures some may be missing.

        If spheres are given, at least all instances in them are tested.
        """
        near = self.near(eye, distance_m, scheme)
        if not near.any():
            return set(), set()
        seen = np.zeros((2, len(near)), bool)

        def look(ways: np.ndarray) -> None:
            looks = self.look(eye.position, ways if towards is None else ways[towards.met(eye, ways)])
            for k, owner in enumerate((looks.first, looks.behind)):
                hit = looks.within(k, eye.position[1] - eye.agent_y, distance_m) if scheme == DISTANCE else owner >= 0
                seen[k, owner[hit & (owner >= 0)]] = True

        targets = self.lines.points[near].reshape(-1, 3)
        ways = toward(targets[np.isfinite(targets[:, 0])], eye.position)
        spread = _framed(eye.yaw_deg, eye.horizon_deg, eye.field_of_view_deg, eye.aspect)
        look(np.concatenate([ways[eye.frames(ways)], spread[::ROUGHLY]]))
        # Most instances are found by now, and only rays past the others can find more.
        look(spread[self._met(np.flatnonzero(near & self._objects & ~seen[0]), eye, spread)])
        first, behind = ({self.lines.names[i] for i in np.flatnonzero(found & near)} for found in seen)
        return first | behind, first

    def _met(self, instances: np.ndarray, eye: Eye, ways: np.ndarray) -> np.ndarray:
        """(K,) bool: which rays along unit vectors (K, 3) within the image may hit the box of one of these instances."""
        frame = axes(eye.yaw_deg, eye.horizon_deg)
        right, up, forward = np.moveaxis((self.lines.corners[instances] - eye.position) @ frame.T, 2, 0)
        high = forward * math.tan(math.radians(eye.field_of_view_deg) / 2)
        wide = high * eye.aspect
        beside = [(forward <= 0), (right > wide), (right < -wide), (up > high), (up < -high)]
        there = ~np.any([outside.all(axis=1) for outside in beside], axis=0) & np.isfinite(forward).all(axis=1)
        right, up, forward = right[there], up[there], forward[there]
        if forward.min(initial=np.inf) <= NEAR_M:
            return np.ones(len(ways), bool)
        x, y, z = frame @ ways.T
        met = np.zeros(len(ways), bool)
        for across, over in zip(right / forward, up / forward, strict=True):
            met |= (np.abs(x / z - (across.min() + across.max()) / 2) <= np.ptp(across) / 2 + ROUNDING_M) & (
                np.abs(y / z - (over.min() + over.max()) / 2) <= np.ptp(over) / 2 + ROUNDING_M
            )
        return met

    def near(self, eye: Eye, distance_m: float, scheme: str = COLLIDER) -> np.ndarray:
        """(N,) bool: which instances have a part that is near enough to be visible."""
        low, high = _tall(eye.axis, distance_m, scheme)
        return self.lines.distances(float(eye.position[0]), float(eye.position[2]), low, high) <= distance_m

    def near_one(
        self, instance: int, camera: np.ndarray, axis: tuple[float, float], distance_m: float, scheme: str = COLLIDER
    ) -> bool:
        """Whether one instance is near enough to be visible from a camera at `camera` (3,). `axis`: see `Eye.axis`."""
        low, high = _tall(axis, distance_m, scheme)
        return self.lines.distance(instance, float(camera[0]), float(camera[2]), low, high) <= distance_m

    def look(self, position: np.ndarray, ways: np.ndarray) -> SightRays:
        """Return the hits of rays from a camera at `position` (3,) along unit vectors (K, 3)."""
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
