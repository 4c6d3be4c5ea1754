"""Rays against a scene, on Embree: what lies where the floor plan has it in one Embree scene, what was displaced in a second.

Embree scenes of the wrapper cannot be changed once made. Moving a thing therefore remakes only the second, small one; and only
rays that pass the boxes of the displaced things are cast into it.
"""

from __future__ import annotations

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numba import njit

from ovman.engine.scene_mesh import SceneMesh

FAR = np.float32(1e30)


def committed(mesh: SceneMesh) -> EmbreeScene | None:
    """An Embree scene of a mesh, ready for rays; None for a mesh without triangles."""
    if len(mesh.triangles) == 0:
        return None
    scene = EmbreeScene()
    TriangleMesh(
        scene, np.ascontiguousarray(mesh.vertices, dtype=np.float32), np.ascontiguousarray(mesh.triangles, dtype=np.int32)
    )
    nowhere = np.full((1, 3), 1e6, dtype=np.float32)
    scene.run(nowhere, nowhere)  # the first ray builds the hierarchy
    return scene


@njit(cache=True, error_model="numpy")
def _passing(origins, directions, reach, lows, highs):
    """Indices of the rays that pass any of the boxes [low, high] (K, 3) before `reach`."""
    found = np.empty(len(origins), np.int64)
    count = 0
    for i in range(len(origins)):
        for k in range(len(lows)):
            near, far = np.float32(0.0), reach[i]
            for a in range(3):
                d, o = directions[i, a], origins[i, a]
                if abs(d) < np.float32(1e-12):
                    if o < lows[k, a] or o > highs[k, a]:
                        far = np.float32(-1.0)
                    continue
                t0, t1 = (lows[k, a] - o) / d, (highs[k, a] - o) / d
                if t0 > t1:
                    t0, t1 = t1, t0
                near, far = max(near, t0), min(far, t1)
            if near <= far:
                found[count] = i
                count += 1
                break
    return found[:count]


class Caster:
    """Casts rays into a fixed and a displaced scene. Triangles of the second are numbered after those of the first."""

    def __init__(self, fixed: EmbreeScene | None, offset: int, displaced: SceneMesh) -> None:
        """`offset`: number of triangles of the fixed mesh."""
        self._fixed, self._offset, self._displaced = fixed, offset, committed(displaced)
        spans = [displaced.vertices[vertices] for vertices, _ in displaced.spans.values()]
        self._lows = np.array([s.min(axis=0) for s in spans], dtype=np.float32).reshape(-1, 3) - np.float32(1e-4)
        self._highs = np.array([s.max(axis=0) for s in spans], dtype=np.float32).reshape(-1, 3) + np.float32(1e-4)

    def closest(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """First hit of each ray (N, 3) float32: triangle (N,) int32 (-1: none), distance in lengths of the direction
        (N,) float32 (at least 1e30 where nothing is hit), and the two barycentric coordinates (N,) float32."""
        if self._fixed is None:
            none = np.zeros(len(origins), np.float32)
            triangle, distance, u, v = np.full(len(origins), -1, np.int32), np.full(len(origins), FAR), none, none.copy()
        else:
            hit = self._fixed.run(origins, directions, query="INTERSECT", output=True)
            triangle, distance, u, v = hit["primID"], hit["tfar"], hit["u"], hit["v"]
        if self._displaced is not None:
            rays = _passing(origins, directions, distance, self._lows, self._highs)
            hit = self._displaced.run(origins[rays], directions[rays], query="INTERSECT", output=True)
            nearer = hit["tfar"] < distance[rays]
            at = rays[nearer]
            triangle[at] = hit["primID"][nearer] + self._offset
            distance[at], u[at], v[at] = hit["tfar"][nearer], hit["u"][nearer], hit["v"][nearer]
        return triangle, distance, u, v

    def occluded(self, origins: np.ndarray, directions: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """Whether anything lies on each ray (N, 3) float32 before `reach` (N,) float32, in lengths of the way: (N,) bool."""
        if self._fixed is None:
            blocked = np.zeros(len(origins), bool)
        else:
            blocked = self._fixed.run(origins, directions, reach, query="OCCLUDED") >= 0
        if self._displaced is not None:
            rays = _passing(origins, directions, reach, self._lows, self._highs)
            rays = rays[~blocked[rays]]
            blocked[rays] = self._displaced.run(origins[rays], directions[rays], reach[rays], query="OCCLUDED") >= 0
        return blocked
