"""Normals at the corners of triangles: smooth where faces meet at a small angle, sharp elsewhere.

This file imports no other kernel: numba's cache watches the file of the compiled function only.
"""

from __future__ import annotations

import numpy as np
from numba import njit

CREASE_DEG = 40.0
"""Faces that meet at less than this angle are shaded as one smooth surface."""
GRAIN_M = 1e-5
"""Coordinates that are equal to this precision are one point."""


@njit(cache=True, error_model="numpy")
def _places(vertices, part):
    """(V,): a number for each vertex that is equal for vertices of one part at one place; and how many numbers exist."""
    keys = np.empty(len(vertices), np.uint64)
    for i in range(len(vertices)):
        key = np.uint64(part[i]) * np.uint64(0xD6E8FEB86659FD93)
        for k in range(3):
            key ^= np.uint64(np.int64(np.round(vertices[i, k] / GRAIN_M)))
            key *= np.uint64(0x9E3779B97F4A7C15)
            key ^= key >> np.uint64(29)
        keys[i] = key
    order = np.argsort(keys)
    places = np.empty(len(vertices), np.int64)
    count = -1
    for j in range(len(order)):
        if j == 0 or keys[order[j]] != keys[order[j - 1]]:
            count += 1
        places[order[j]] = count
    return places, count + 1


@njit(cache=True, error_model="numpy")
def _normals(vertices, triangles, part, turns, cosine, normals, axis):
    """See `normals` and `axes`."""
    area, own = np.empty((len(triangles), 3)), np.empty((len(triangles), 3))
    part_of_vertex = np.zeros(len(vertices), np.int64)
    for t in range(len(triangles)):
        a, b, c = triangles[t]
        for corner in triangles[t]:
            part_of_vertex[corner] = part[t]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            area[t, k] = (vertices[b, i] - vertices[a, i]) * (vertices[c, j] - vertices[a, j])
            area[t, k] -= (vertices[b, j] - vertices[a, j]) * (vertices[c, i] - vertices[a, i])
        length = np.sqrt(area[t, 0] ** 2 + area[t, 1] ** 2 + area[t, 2] ** 2)
        most = -1.0
        for k in range(3):
            own[t, k] = area[t, k] / (length if length > 0 else 1.0)
        for k in range(3):
            along = 0.0
            for i in range(3):
                along += own[t, i] * turns[part[t], i, k]
            if abs(along) > most + 1e-9:
                most = abs(along)
                axis[t] = k
    places, count = _places(vertices, part_of_vertex)
    starts = np.zeros(count + 1, np.int64)
    for t in range(len(triangles)):
        for k in range(3):
            starts[places[triangles[t, k]] + 1] += 1
    for p in range(count):
        starts[p + 1] += starts[p]
    filled, faces = starts[:-1].copy(), np.empty(3 * len(triangles), np.int64)
    for t in range(len(triangles)):
        for k in range(3):
            p = places[triangles[t, k]]
            faces[filled[p]] = t
            filled[p] += 1
    for t in range(len(triangles)):
        for k in range(3):
            p = places[triangles[t, k]]
            x, y, z = 0.0, 0.0, 0.0
            for j in range(starts[p], starts[p + 1]):
                f = faces[j]
                if own[t, 0] * own[f, 0] + own[t, 1] * own[f, 1] + own[t, 2] * own[f, 2] > cosine:
                    x += area[f, 0]
                    y += area[f, 1]
                    z += area[f, 2]
            length = np.sqrt(x * x + y * y + z * z)
            if length > 0:
                normals[t, k, 0], normals[t, k, 1], normals[t, k, 2] = x / length, y / length, z / length
            else:
                normals[t, k, 0], normals[t, k, 1], normals[t, k, 2] = own[t, 0], own[t, 1], own[t, 2]


def of_parts(
    vertices: np.ndarray, triangles: np.ndarray, part: np.ndarray, turns: np.ndarray, crease_deg: float = CREASE_DEG
) -> tuple[np.ndarray, np.ndarray]:
    """Return unit normals (T, 3, 3) at the corners of triangles (T, 3) over vertices (V, 3).

    Also (T,) int32, the axis of its part that each triangle faces.

    At a corner the normal is the area-weighted mean of those of all triangles of the same part (T,) at that point that make less
    than `crease_deg` with the corner's own triangle. Parts have no vertices in common. `turns` (P, 3, 3): rotations of the parts.
    """
    normals, axis = np.empty((len(triangles), 3, 3)), np.empty(len(triangles), np.int32)
    _normals(
        np.ascontiguousarray(vertices, dtype=float), np.ascontiguousarray(triangles, dtype=np.int32),
        np.ascontiguousarray(part, dtype=np.int32), np.ascontiguousarray(turns, dtype=float),
        np.cos(np.radians(crease_deg)), normals, axis,
    )  # fmt: skip
    return normals, axis
