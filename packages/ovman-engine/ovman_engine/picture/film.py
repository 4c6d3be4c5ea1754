"""From linear light to eight bits: adds reflections, finds edges that need more samples, and applies the film curve.

All numbers are float32, in a fixed order and without fast-math. This file imports no other kernel: numba's cache watches the file
of the compiled function only.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit

CURVE = 4096
"""Entries of the table from linear light to eight bits."""
BRIGHTEST = 4.0
"""Largest linear light in the table."""
OFFSET = 0.4
"""Distance of the second sample of an edge pixel from its centre, in pixels along each axis."""
CONTRAST = (0.15, 0.45)
"""Least relative difference of two neighbours at which an edge is smoothed: between instances, and within one."""


@cache
def curve() -> np.ndarray:
    """(4096,) float32: displayed value 0..255 of linear light 0..4: a soft shoulder, then the sRGB curve."""
    light = np.linspace(0, BRIGHTEST, CURVE)
    knee = 0.55
    light = np.where(light < knee, light, knee + (1 - knee) * (1 - np.exp(-(light - knee) / (1 - knee))))
    shown = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)
    return np.round(np.clip(shown, 0, 1) * 255, 3).astype(np.float32)


@njit(cache=True, error_model="numpy")
def mirror(which, gloss, seen, linear):
    """Blends reflections, seen (M, 3), into linear (N, 3) at `which` (M,), in proportion to gloss (M,)."""
    for j in range(len(which)):
        share = (gloss[j] - np.float32(0.7)) / np.float32(0.3)
        share *= share * np.float32(0.85)
        for k in range(3):
            linear[which[j], k] += share * (seen[j, k] - linear[which[j], k])


@njit(cache=True, error_model="numpy")
def edges(ids, depth, normals, linear, width, height, found, aside, down):
    """Find pixels at visible edges (another instance, another face, a step in depth).

    Writes their numbers to found (H W,) and returns their number. aside and down (H W,) float32: direction from the pixel's
    centre to its different neighbour, pixels.
    """
    marked = np.zeros((width * height, 2), np.int8)
    least, within = np.float32(CONTRAST[0]), np.float32(CONTRAST[1])
    for y in range(height):
        for x in range(width):
            n = y * width + x
            for k in range(2):
                if (k == 0 and x + 1 >= width) or (k == 1 and y + 1 >= height):
                    continue
                m = n + 1 if k == 0 else n + width
                unlike = abs(linear[n, 0] - linear[m, 0]) + abs(linear[n, 1] - linear[m, 1]) + abs(linear[n, 2] - linear[m, 2])
                bright = linear[n, 0] + linear[n, 1] + linear[n, 2] + linear[m, 0] + linear[m, 1] + linear[m, 2]
                bright = np.float32(0.5) * bright + np.float32(0.03)
                if unlike < least * bright:
                    continue
                breaks = ids[n] != ids[m]
                if not breaks and ids[n] >= 0 and unlike > within * bright:
                    step = abs(depth[n] - depth[m])
                    alike = normals[n, 0] * normals[m, 0] + normals[n, 1] * normals[m, 1] + normals[n, 2] * normals[m, 2]
                    breaks = alike < np.float32(0.8) or step > np.float32(0.06) * min(depth[n], depth[m])
                if breaks:
                    marked[n, k] += 1
                    marked[m, k] -= 1
                    if marked[n, k] == 0:  # both neighbours differ: one of them is used
                        marked[n, k] = 1
                    if marked[m, k] == 0:
                        marked[m, k] = -1
    count = 0
    for n in range(width * height):
        if marked[n, 0] != 0 or marked[n, 1] != 0:
            found[count] = n
            aside[count], down[count] = np.float32(OFFSET * marked[n, 0]), np.float32(OFFSET * marked[n, 1])
            count += 1
    return count


@njit(cache=True, error_model="numpy")
def develop(linear, table, extra, pixels, out):
    """Eight-bit image (N, 3) uint8 of linear light (N, 3). extra (len(pixels), 3) are second samples of `pixels`.

    They are averaged with the first ones after the curve, not as light, so that bright edges stay smooth.
    """
    scale = np.float32((CURVE - 1) / BRIGHTEST)
    last = np.float32(CURVE - 1)
    for i in range(len(linear)):
        for k in range(3):
            x = min(max(linear[i, k] * scale, np.float32(0)), last)
            out[i, k] = np.uint8(table[np.int64(x)] + np.float32(0.5))
    for j in range(len(pixels)):
        n = pixels[j]
        for k in range(3):
            first = min(max(linear[n, k] * scale, np.float32(0)), last)
            second = min(max(extra[j, k] * scale, np.float32(0)), last)
            out[n, k] = np.uint8(np.float32(0.5) * (table[np.int64(first)] + table[np.int64(second)]) + np.float32(0.5))
