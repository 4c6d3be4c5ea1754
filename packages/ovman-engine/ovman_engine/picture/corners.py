"""Normals at the corners of triangles: smooth where faces meet at a small angle, sharp elsewhere."""

from __future__ import annotations

import numpy as np

from ovman_engine import kernels

CREASE_DEG = 40.0
"""Faces that meet at less than this angle are shaded as one smooth surface."""


def of_parts(
    vertices: np.ndarray, triangles: np.ndarray, part: np.ndarray, turns: np.ndarray, crease_deg: float = CREASE_DEG
) -> tuple[np.ndarray, np.ndarray]:
    """Return unit normals (T, 3, 3) at the corners of triangles (T, 3) over vertices (V, 3).

    Also (T,) int32, the axis of its part that each triangle faces.

    At a corner the normal is the area-weighted mean of those of all triangles of the same part (T,) at that point that make less
    than `crease_deg` with the corner's own triangle. Parts have no vertices in common. `turns` (P, 3, 3): rotations of the parts.
    """
    return kernels.corner_normals(vertices, triangles, part, turns, np.cos(np.radians(crease_deg)))
