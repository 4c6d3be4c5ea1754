"""The primary rays of a view, and the surfaces that they hit.

All numbers are float32, in a fixed order and without fast-math. This file imports no other kernel: numba's cache watches the file
of the compiled function only.
"""

from __future__ import annotations

import numpy as np
from numba import njit

MIRROR = 0.85
"""Least gloss of a surface that mirrors."""
PANE_M = 0.02
"""A ray through glass starts this far behind its face."""
LIFT_M = np.float32(0.004)
"""Rays from a surface start this far above it."""


@njit(cache=True, error_model="numpy")
def primary(right, up, forward, tan_x, tan_y, eye, near, flat, columns, rows, width, height, origins, rays):
    """Write the rays through N image points to origins and rays (N, 3) float32.

    columns, rows (N,) float32: image points in pixels, row 0 at the top, centres at +0.5. The length of a ray along `forward` is
    1, so distances along it are planar depths beyond `near`, where it starts. `flat`: all rays are parallel (orthographic), and
    tan_x and tan_y are half the width and height of the image in metres.
    """
    for i in range(len(columns)):
        x = (np.float32(2) * columns[i] / np.float32(width) - np.float32(1)) * tan_x
        y = (np.float32(1) - np.float32(2) * rows[i] / np.float32(height)) * tan_y
        for a in range(3):
            aside = right[a] * x + up[a] * y
            rays[i, a] = forward[a] if flat else aside + forward[a]
            origins[i, a] = eye[a] + near * rays[i, a] + (aside if flat else np.float32(0))


@njit(cache=True, error_model="numpy")
def identify(prim, distance, instance, near, far, ids, depth):
    """Write instance ids (N,) int32 (-1 without a hit) and planar depth (N,) float32 metres (`far` without a hit) of N hits."""
    span = far - near
    for i in range(len(prim)):
        if prim[i] >= 0 and distance[i] <= span:
            ids[i] = instance[prim[i]]
            depth[i] = distance[i] + near
        else:
            ids[i] = -1
            depth[i] = far


@njit(cache=True, error_model="numpy")
def surface(prim, u, v, distance, origins, rays, tri_normals, pixel, flat, points, normals, footprint):
    """Write points (N, 3), unit normals (N, 3) towards the viewer and pixel footprints (N,) metres of N hits.

    `pixel`: width of a pixel at a distance of one metre, metres (at any distance in an orthographic image: `flat`).
    """
    for i in range(len(prim)):
        t = prim[i]
        if t < 0:
            normals[i, 0], normals[i, 1], normals[i, 2] = np.float32(0), np.float32(0), np.float32(0)
            continue
        d = distance[i]
        a, b = u[i], v[i]
        c = np.float32(1) - a - b
        dx, dy, dz = rays[i, 0], rays[i, 1], rays[i, 2]
        x = c * tri_normals[t, 0, 0] + a * tri_normals[t, 1, 0] + b * tri_normals[t, 2, 0]
        y = c * tri_normals[t, 0, 1] + a * tri_normals[t, 1, 1] + b * tri_normals[t, 2, 1]
        z = c * tri_normals[t, 0, 2] + a * tri_normals[t, 1, 2] + b * tri_normals[t, 2, 2]
        facing = x * dx + y * dy + z * dz
        size = x * x + y * y + z * z
        scale = np.float32(1) / np.sqrt(max(size, np.float32(1e-12)))
        if facing > 0:
            scale = -scale
        normals[i, 0], normals[i, 1], normals[i, 2] = x * scale, y * scale, z * scale
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        grazing = max(abs(facing * scale) / length, np.float32(0.2))
        footprint[i] = pixel / grazing if flat else pixel * d * length / grazing
        for k in range(3):
            points[i, k] = origins[i, k] + d * rays[i, k]


@njit(cache=True, error_model="numpy")
def mirrors(prim, tri_material, glosses):
    """Numbers (M,) of the points whose material mirrors or is glass."""
    found = np.empty(len(prim), np.int64)
    count = 0
    for i in range(len(prim)):
        if prim[i] >= 0 and glosses[tri_material[prim[i]]] >= np.float32(MIRROR):
            found[count] = i
            count += 1
    return found[:count]


@njit(cache=True, error_model="numpy")
def mirrored(which, points, normals, rays, clear, starts, ways):
    """Write the rays (M, 3) of the points `which` (M,): reflected, or straight on behind a pane where `clear` (M,)."""
    for j in range(len(which)):
        i = which[j]
        if clear[j]:
            dx, dy, dz = rays[i, 0], rays[i, 1], rays[i, 2]
            through = np.float32(PANE_M) / np.sqrt(dx * dx + dy * dy + dz * dz)
            for k in range(3):
                starts[j, k] = points[i, k] + through * rays[i, k]
                ways[j, k] = rays[i, k]
            continue
        along = np.float32(2) * (rays[i, 0] * normals[i, 0] + rays[i, 1] * normals[i, 1] + rays[i, 2] * normals[i, 2])
        for k in range(3):
            starts[j, k] = points[i, k] + normals[i, k] * LIFT_M
            ways[j, k] = rays[i, k] - along * normals[i, k]
