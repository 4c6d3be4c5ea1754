"""Lines of sight: the first instance on a ray, on the triangles that images show.

Untouched objects are one solid for each floor plan, built once: rays continue through objects that are no longer there.
Displaced objects are a second, small scene. World frame as in `floorplan`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from ovman_engine import kernels
from ovman_engine.picture import painter, scene_mesh
from ovman_engine.picture.scene_mesh import PlanMeshes
from ovman_engine.picture.triangle_mesh import TriangleMesh

NOTHING, GONE = -1, -2
"""Owners of rays that hit nothing, and of triangles that are no longer there."""
ONWARDS_M = np.float32(1e-4)
"""A ray that passes an instance continues this far behind it."""
TRANSPARENT = frozenset(["Window", "ShowerDoor", "ShowerGlass"])
"""Types that are seen through. Objects behind them are visible and not interactable."""
POINTS = 32
"""Number of points on the surface of each object to which rays are cast."""
_STEPS = np.arange(POINTS) + 0.5
_ROOT = np.sqrt(_STEPS * 0.7548776662466927 % 1.0)
_WEIGHTS = np.stack([1 - _ROOT, _ROOT * (1 - _STEPS * 0.5698402909980532 % 1.0), _ROOT * (_STEPS * 0.5698402909980532 % 1.0)], 1)
"""(POINTS, 3) barycentric coordinates, evenly spread over a triangle."""


@dataclass(frozen=True)
class Surface:
    """The data of a mesh that visibility needs: N instances, P parts."""

    owner: np.ndarray
    """(T,) int32 instance of each triangle"""
    points: np.ndarray
    """(N, POINTS, 3) float32 points spread evenly over each instance's surface; NaN for an instance without one"""
    frames: np.ndarray
    """(P, 3, 4) from world points to the frames of the parts"""
    halves: np.ndarray
    """(P, 3) half extents of the parts"""
    part_owner: np.ndarray
    """(P,) int instance of each part; -1 for parts without triangles"""

    @staticmethod
    def of(mesh: TriangleMesh) -> Surface:
        """Return the surface of `mesh`."""
        part_owner = np.full(len(mesh.frames), NOTHING)
        part_owner[mesh.part] = mesh.instance
        return Surface(mesh.instance, _spread(mesh), mesh.frames, mesh.extents, part_owner)

    def gaps(self, x: float, z: float, low: float, high: float, chosen: slice | np.ndarray = slice(None)) -> np.ndarray:
        """Return distances (P,) metres from the vertical segment at (x, z) between heights `low` and `high` to boxes.

        The boxes are those of the parts `chosen`.
        """
        turn, shift, halves = self.frames[chosen, :, :3], self.frames[chosen, :, 3], self.halves[chosen]
        middle = -np.einsum("pi,pi->p", turn[:, :, 1], shift)
        reach = np.einsum("pi,pi->p", np.abs(turn[:, :, 1]), halves)
        beside = turn[:, :, 0] * x + turn[:, :, 2] * z + shift
        gap = np.full(len(middle), np.inf)
        for height in (middle, middle - reach, middle + reach):
            local = beside + turn[:, :, 1] * np.clip(height, low, high)[:, None]
            gap = np.minimum(gap, (np.maximum(np.abs(local) - halves, 0.0) ** 2).sum(axis=1))
        return np.sqrt(gap)


def _spread(mesh: TriangleMesh) -> np.ndarray:
    """Points (N, POINTS, 3) on the surfaces of the instances, evenly spread over the triangles in their order."""
    points = np.full((len(mesh.names), POINTS, 3), np.nan, dtype=np.float32)
    if len(mesh.triangles) == 0:
        return points
    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(float), axis=1)
    total = np.cumsum(np.maximum(area, 1e-12))
    starts = np.flatnonzero(np.diff(mesh.instance, prepend=NOTHING))
    before, after = total[starts] - np.maximum(area[starts], 1e-12), total[np.append(starts[1:], len(area)) - 1]
    at = before[:, None] + (after - before)[:, None] * _STEPS / POINTS
    triangle = np.minimum(np.searchsorted(total, at), len(area) - 1)
    points[mesh.instance[starts]] = np.einsum(
        "nka,nkai->nki", np.broadcast_to(_WEIGHTS, (len(starts), POINTS, 3)), corners[triangle]
    )
    return points


class Sightlines:
    """Casts rays through the current state of a world."""

    def __init__(self, world) -> None:
        """Follows no later change of `world`."""
        plan_meshes = scene_mesh.of_plan(world.plan, world.room)
        now = scene_mesh.changes(world)
        moved = plan_meshes.posed(now.placements)
        self.names = moved.names
        """(N,) instances: objectIds of the floor plan, structures, copies"""
        self.index = {name: i for i, name in enumerate(self.names)}
        gone = [plan_meshes.index(o) for o in now.displaced]
        standing = _standing(plan_meshes)
        is_gone = np.zeros(len(self.names) + 1, dtype=bool)
        is_gone[gone] = True
        owner = np.where(is_gone[standing.owner], np.int32(GONE), standing.owner)
        self._owner = np.concatenate([owner, moved.instance, np.array([NOTHING], dtype=np.int32)])
        self._solids = [scene_mesh.solid(plan_meshes), painter.solid(moved)]
        self.points = np.full((len(self.names), POINTS, 3), np.nan, dtype=np.float32)
        self.points[: len(standing.points)] = standing.points
        self.points[gone] = np.nan
        kept = ~is_gone[standing.part_owner]
        surface = Surface.of(moved)
        there = np.unique(moved.instance)
        self.points[there] = surface.points[there]
        self._parts = Surface(
            owner,
            self.points,
            np.concatenate([standing.frames[kept], surface.frames]),
            np.concatenate([standing.halves[kept], surface.halves]),
            np.concatenate([standing.part_owner[kept], surface.part_owner]),
        )

    def distances(self, x: float, z: float, low: float, high: float) -> np.ndarray:
        """(N,) metres: distance from a vertical segment to each instance, by the boxes around its parts."""
        known = self._parts.part_owner >= 0
        nearest = np.full(len(self.names), np.inf)
        np.minimum.at(nearest, self._parts.part_owner[known], self._parts.gaps(x, z, low, high)[known])
        return nearest

    def distance(self, instance: int, x: float, z: float, low: float, high: float) -> float:
        """Return the entry of `distances` for one instance."""
        own = np.flatnonzero(self._parts.part_owner == instance)
        return float(self._parts.gaps(x, z, low, high, own).min(initial=np.inf))

    @cached_property
    def corners(self) -> np.ndarray:
        """(N, 8, 3) metres: corners of an upright box around each instance, not finite where it has no part."""
        known = self._parts.part_owner >= 0
        owner, turn, shift = self._parts.part_owner[known], self._parts.frames[known, :, :3], self._parts.frames[known, :, 3]
        middle = -np.einsum("pji,pj->pi", turn, shift)
        reach = np.einsum("pji,pj->pi", np.abs(turn), self._parts.halves[known])
        ends = np.full((2, len(self.names), 3), np.inf)
        np.minimum.at(ends[0], owner, middle - reach)
        np.minimum.at(ends[1], owner, -middle - reach)
        ends[1] *= -1
        return np.stack([ends[[i, j, k], :, [0, 1, 2]].T for i in (0, 1) for j in (0, 1) for k in (0, 1)], axis=1)

    def first(self, origins: np.ndarray, ways: np.ndarray, passed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the first instance on each ray (K, 3) along unit vectors `ways` (K, 3): (K,) int, NOTHING without a hit.

        And its distance (K,) metres.

        Rays pass through the instances that are `passed` (N,) bool.
        """
        origins, ways = np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(ways, np.float32)
        triangle, distance = kernels.closest(self._solids, origins, ways)[:2]
        owner = self._owner[triangle]
        skips = np.concatenate([passed, [True, False]])
        going = np.flatnonzero(skips[owner])
        while len(going):
            begun = distance[going] + ONWARDS_M
            triangle, further = kernels.closest(self._solids, origins[going] + ways[going] * begun[:, None], ways[going])[:2]
            distance[going], owner[going] = begun + further, self._owner[triangle]
            going = going[skips[owner[going]]]
        return owner, distance


_surfaces: WeakKeyDictionary[PlanMeshes, Surface] = WeakKeyDictionary()


def _standing(meshes: PlanMeshes) -> Surface:
    """Surface of the untouched scene, cached."""
    if meshes not in _surfaces:
        _surfaces[meshes] = Surface.of(meshes.untouched)
    return _surfaces[meshes]
