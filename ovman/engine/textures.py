"""Procedural textures, evaluated where a ray hits: what a point of a material looks like.

A texture lies in the frame of its part, so it moves with the thing. It has two coordinates (metres) on the face that the ray hit,
the half extents of that face, the material's colour, scale and seed, and the footprint of the pixel there (metres): structure
that is finer than the footprint fades to its mean instead of flickering. `scale_m` is the period of the pattern.

The file is self-contained on purpose: numba's cache watches the file of the compiled function alone.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit

KINDS = (
    "plain",
    "wood",
    "fabric",
    "weave",
    "tiles",
    "marble",
    "metal_brushed",
    "print",
    "picture",
    "leaves",
    "pages",
    "cardboard",
)
KINDS += ("checker", "stripes", "screen")
PLAIN, WOOD, FABRIC, WEAVE, TILES, MARBLE, METAL, PRINT, PICTURE, LEAVES, PAGES, CARDBOARD, CHECKER, STRIPES, SCREEN = range(
    len(KINDS)
)
TILE = 256
"""Width of the noise tables; a power of two."""
CLOUDS, GRAIN, VEINS, THREAD = range(4)


@cache
def noise() -> np.ndarray:
    """Four tileable noise tables (4, 256, 256) float32 in [-1, 1]: clouds, grain along the second axis, veins, thread."""
    rng = np.random.default_rng(20240)
    y, x = np.meshgrid(np.fft.fftfreq(TILE) * TILE, np.fft.fftfreq(TILE) * TILE, indexing="ij")

    def filtered(spectrum: np.ndarray) -> np.ndarray:
        field = np.fft.ifft2(np.fft.fft2(rng.standard_normal((TILE, TILE))) * spectrum).real
        field = field / (2.2 * field.std())
        return np.round(np.clip(field, -1, 1) * 1000) / 1000  # the last bit of an FFT differs between processors

    radius = np.hypot(x, y)
    clouds = filtered(np.where(radius > 0, 1 / np.maximum(radius, 1) ** 1.6, 0))
    grain = filtered(np.where(radius > 0, np.exp(-((x / 2.5) ** 2)) / np.maximum(np.abs(y), 2) ** 0.75, 0))
    veins = 1 - 2 * np.minimum(np.abs(filtered(np.where(radius > 1, 1 / np.maximum(radius, 1) ** 1.9, 0))) * 3.0, 1)
    thread = filtered(np.exp(-(((radius - 40) / 30) ** 2)))
    return np.stack([clouds, grain, veins, thread]).astype(np.float32)


@njit(cache=True, error_model="numpy", inline="always")
def _hash(a, b, c):
    h = np.uint32(a) * np.uint32(374761393) + np.uint32(b) * np.uint32(668265263) + np.uint32(c) * np.uint32(2246822519)
    h = (h ^ (h >> np.uint32(13))) * np.uint32(1274126177)
    h = h ^ (h >> np.uint32(16))
    return np.float32(h & np.uint32(0xFFFFFF)) * np.float32(1.0 / 16777216.0)


@njit(cache=True, error_model="numpy")
def _look(table, k, x, y):
    """Table k at (x, y) in cells, wrapped around, bilinear."""
    fx, fy = np.floor(x), np.floor(y)
    ix, iy = np.int64(fx), np.int64(fy)
    tx, ty = x - np.float32(fx), y - np.float32(fy)
    x0, x1, y0, y1 = ix & (TILE - 1), (ix + 1) & (TILE - 1), iy & (TILE - 1), (iy + 1) & (TILE - 1)
    top = table[k, y0, x0] * (np.float32(1) - tx) + table[k, y0, x1] * tx
    low = table[k, y1, x0] * (np.float32(1) - tx) + table[k, y1, x1] * tx
    return top * (np.float32(1) - ty) + low * ty


@njit(cache=True, error_model="numpy", inline="always")
def _fade(footprint, period):
    """1 where a structure of this period is well resolved, 0 where pixels are as wide as it."""
    f = np.float32(1.6) - np.float32(2.0) * footprint / period
    return min(max(f, np.float32(0)), np.float32(1))


@njit(cache=True, error_model="numpy")
def _second(r, g, b, seed):
    """A colour that goes with another one: lighter or darker, slightly turned in hue."""
    turn = np.float32(0.25) * _hash(seed, 71, 5)
    r2, g2, b2 = r + (g - r) * turn, g + (b - g) * turn, b + (r - b) * turn
    mean = np.float32(0.33) * (r + g + b)
    if mean > np.float32(0.30) - np.float32(0.12) * _hash(seed, 72, 5):
        k = np.float32(0.30) + np.float32(0.25) * _hash(seed, 73, 5)
        return r2 * k, g2 * k, b2 * k
    k = np.float32(0.35) + np.float32(0.25) * _hash(seed, 73, 5)
    return r2 + (np.float32(0.85) - r2) * k, g2 + (np.float32(0.82) - g2) * k, b2 + (np.float32(0.76) - b2) * k


@njit(cache=True, error_model="numpy")
def _picture(s, t, r, g, b, seed):
    """An abstract painting on the unit square: ground, sky, a sun and some strokes; t upwards."""
    one = np.float32(1)
    r2, g2, b2 = _second(r, g, b, seed)
    style = _hash(seed, 11, 0)
    if style < 0.45:
        line = np.float32(0.3) + np.float32(0.35) * _hash(seed, 12, 0)
        line += np.float32(0.05) * np.sin(np.float32(6.3) * (s * (one + np.float32(2) * _hash(seed, 13, 0)) + _hash(seed, 14, 0)))
        cx, cy = np.float32(0.2) + np.float32(0.6) * _hash(seed, 15, 0), line + np.float32(0.2)
        if t < line:
            k = np.float32(0.6) + np.float32(0.4) * t / line
            return r2 * k, g2 * k, b2 * k
        if (s - cx) * (s - cx) + (t - cy) * (t - cy) < np.float32(0.012):
            return np.float32(0.85), np.float32(0.6), np.float32(0.35)
        k = (t - line) / (one - line)
        return (
            r + (np.float32(0.8) - r) * (one - k),
            g + (np.float32(0.75) - g) * (one - k),
            b + (np.float32(0.7) - b) * (one - k),
        )
    out_r, out_g, out_b = np.float32(0.72), np.float32(0.68), np.float32(0.6)
    for i in range(6):
        x, y = _hash(seed, 20 + i, 1), _hash(seed, 20 + i, 2)
        w, h = (
            np.float32(0.08) + np.float32(0.28) * _hash(seed, 20 + i, 3),
            np.float32(0.08) + np.float32(0.28) * _hash(seed, 20 + i, 4),
        )
        k = np.float32(0.35) + np.float32(0.9) * _hash(seed, 20 + i, 5)
        inside = abs(s - x) < w and abs(t - y) < h
        if style > 0.75:
            inside = (s - x) * (s - x) + (t - y) * (t - y) < w * w
        if inside:
            if i & 1:
                out_r, out_g, out_b = r * k, g * k, b * k
            else:
                out_r, out_g, out_b = r2 * k, g2 * k, b2 * k
    return min(out_r, one), min(out_g, one), min(out_b, one)


@njit(cache=True, error_model="numpy")
def _texel(kind, u, v, hu, hv, scale, seed, footprint, r, g, b, emission, table):
    """Colour (r, g, b) of one point; see the module."""
    if kind == PLAIN:
        return r, g, b
    one, half = np.float32(1), np.float32(0.5)
    ou, ov = np.float32(37.0) * _hash(seed, 1, 1), np.float32(37.0) * _hash(seed, 2, 1)
    if kind == WOOD:
        if hv > hu:
            u, v, hu, hv = v, u, hv, hu
        tone = one
        if hv > np.float32(0.9):
            wide = max(scale, np.float32(0.09))
            long = wide * np.float32(8.5)
            row = np.floor(v / wide)
            along = u / long + _hash(np.int64(row), seed, 3)
            board = np.floor(along)
            pick = _hash(np.int64(row), np.int64(board), seed)
            tone = np.float32(0.80) + np.float32(0.34) * pick
            ou += np.float32(9) * pick
            gap = min(v / wide - row, one - (v / wide - row)) * wide
            gap = min(gap, min(along - board, one - (along - board)) * long)
            seam = np.float32(0.004) + footprint * half
            if gap < seam:
                tone *= one - np.float32(0.42) * (one - gap / seam) * np.float32(0.004) / (np.float32(0.002) + footprint * half)
        k = (
            _look(table, GRAIN, (u + ou) * np.float32(60), (v + ov) * np.float32(520))
            * _fade(footprint, np.float32(0.030))
            * np.float32(0.20)
        )
        k += _look(table, CLOUDS, (u + ou) * np.float32(30), (v + ov) * np.float32(170)) * np.float32(0.12)
        k = tone * (one + k)
        return r * k, g * k * (one - np.float32(0.03) * (one - k)), b * k
    if kind == FABRIC:
        k = (
            np.float32(0.10)
            * _look(table, THREAD, (u + ou) * np.float32(400), (v + ov) * np.float32(400))
            * _fade(footprint, np.float32(0.016))
        )
        k += one + np.float32(0.08) * _look(table, CLOUDS, (u + ou) * np.float32(90), (v + ov) * np.float32(90))
        return r * k, g * k, b * k
    if kind == WEAVE:
        period = max(scale, np.float32(0.012))
        a, c = u / period, v / period
        ia, ic = np.int64(np.floor(a)), np.int64(np.floor(c))
        fa, fc = a - np.float32(np.floor(a)) - half, c - np.float32(np.floor(c)) - half
        across = fa if (ia + ic) & 1 else fc
        k = one - min(np.float32(1.5), np.float32(0.06) / period) * across * across * _fade(footprint, period)
        k *= one + np.float32(0.10) * (_hash(ia, ic, seed) - half) * _fade(footprint, period)
        return r * k, g * k, b * k
    if kind == TILES:
        period = max(scale, np.float32(0.04))
        a, c = u / period, v / period
        ia, ic = np.floor(a), np.floor(c)
        edge = min(min(a - ia, one - (a - ia)), min(c - ic, one - (c - ic))) * period
        k = np.float32(0.95) + np.float32(0.10) * _hash(np.int64(ia), np.int64(ic), seed)
        k += np.float32(0.05) * _look(table, CLOUDS, (u + ou) * np.float32(80), (v + ov) * np.float32(80))
        seam = np.float32(0.005) + footprint * half
        if edge < seam:
            deep = (one - edge / seam) * np.float32(0.005) / (np.float32(0.0025) + footprint * half)
            deep = min(deep, one)
            mean = np.float32(0.33) * (r + g + b)
            grout = np.float32(0.16) if mean > np.float32(0.3) else np.float32(0.5)
            return r * k + (grout - r * k) * deep, g * k + (grout - g * k) * deep, b * k + (grout - b * k) * deep
        return r * k, g * k, b * k
    if kind == MARBLE:
        vein = _look(table, VEINS, (u + ou) * np.float32(70), (v + ov) * np.float32(70))
        vein = max(vein, np.float32(0)) * _fade(footprint, np.float32(0.06))
        k = one + np.float32(0.10) * _look(table, CLOUDS, (u + ov) * np.float32(60), (v + ou) * np.float32(60))
        r2, g2, b2 = _second(r, g, b, seed)
        w = np.float32(0.35) * vein
        return r * k + (r2 - r) * w, g * k + (g2 - g) * w, b * k + (b2 - b) * w
    if kind == METAL:
        k = one + np.float32(0.10) * _look(table, GRAIN, (u + ou) * np.float32(20), (v + ov) * np.float32(600)) * _fade(
            footprint, np.float32(0.03)
        )
        k += np.float32(0.04) * _look(table, CLOUDS, (u + ou) * np.float32(40), (v + ov) * np.float32(40))
        return r * k, g * k, b * k
    if kind == PRINT:
        period = max(scale, np.float32(0.03))
        a, c = u / period, v / period
        ia, ic = np.floor(a), np.floor(c)
        if np.int64(ic) & 1:
            a += half
            ia = np.floor(a)
        x, y = a - ia - half, c - ic - half
        far = np.sqrt(x * x + y * y)
        motif = _hash(seed, 5, 1)
        if motif < 0.34:
            d = far - np.float32(0.26)
        elif motif < 0.67:
            d = far - np.float32(0.24) * (
                one
                + half
                * (x * x * x * x + y * y * y * y - np.float32(6) * x * x * y * y)
                / (far * far * far * far + np.float32(1e-6))
            )
        else:
            d = (abs(x) + abs(y)) - np.float32(0.32)
        soft = max(footprint / period, np.float32(0.02))
        w = min(max(half - d / soft, np.float32(0)), one)
        w = np.float32(0.25) + (w - np.float32(0.25)) * _fade(footprint, period)
        r2, g2, b2 = _second(r, g, b, seed)
        k = one + np.float32(0.05) * _look(table, CLOUDS, (u + ou) * np.float32(90), (v + ov) * np.float32(90))
        return (r + (r2 - r) * w) * k, (g + (g2 - g) * w) * k, (b + (b2 - b) * w) * k
    if kind == PICTURE:
        return _picture(u / (hu + hu) + half, v / (hv + hv) + half, r, g, b, seed)
    if kind == LEAVES:
        k = one + np.float32(0.28) * _look(table, CLOUDS, (u + ou) * np.float32(500), (v + ov) * np.float32(500)) * _fade(
            footprint, np.float32(0.06)
        )
        rib = np.float32(0.003)
        if hu < hv:
            u, hu = v, hv
        if min(hu, hv) < np.float32(0.15) and abs(u) < rib:
            k *= np.float32(1.2)
        k *= np.float32(0.8) + np.float32(0.4) * _hash(seed, 3, 1)
        return r * k, g * k, b * k
    if kind == PAGES:
        period = np.float32(0.004)
        k = one - np.float32(0.25) * (_hash(np.int64(np.floor(v / period)), seed, 4)) * (
            np.float32(0.4) + np.float32(0.6) * _fade(footprint, period)
        )
        return r * k, g * k, b * k
    if kind == CARDBOARD:
        k = one + np.float32(0.08) * _look(table, CLOUDS, (u + ou) * np.float32(60), (v + ov) * np.float32(200))
        if abs(u) < np.float32(0.025) and hu > np.float32(0.06):
            return (r * half + np.float32(0.30)) * k, (g * half + np.float32(0.25)) * k, (b * half + np.float32(0.18)) * k
        return r * k, g * k, b * k
    if kind == CHECKER:
        period = max(scale, np.float32(0.02))
        r2, g2, b2 = _second(r, g, b, seed)
        w = np.float32((np.int64(np.floor(u / period)) + np.int64(np.floor(v / period))) & 1)
        w = half + (w - half) * _fade(footprint, period)
        return r + (r2 - r) * w, g + (g2 - g) * w, b + (b2 - b) * w
    if kind == STRIPES:
        period = max(scale, np.float32(0.015))
        r2, g2, b2 = _second(r, g, b, seed)
        duty = np.float32(0.25) + np.float32(0.3) * _hash(seed, 6, 1)
        phase = u / period - np.floor(u / period)
        edge = max(footprint / period, np.float32(0.01))
        w = min(max((duty - phase) / edge + half, np.float32(0)), one)
        w = duty + (w - duty) * _fade(footprint, period)
        return r + (r2 - r) * w, g + (g2 - g) * w, b + (b2 - b) * w
    if kind == SCREEN:
        s, t = u / (hu + hu) + half, v / (hv + hv) + half
        if emission > np.float32(0.05):
            k = np.float32(0.5) + np.float32(0.5) * t
            r, g, b = r * k, g * k, b * k
            for i in range(3):
                x, y = _hash(seed, 30 + i, 1), _hash(seed, 30 + i, 2)
                if abs(s - x) < np.float32(0.18) and abs(t - y) < np.float32(0.16):
                    k = half + _hash(seed, 30 + i, 3)
                    r, g, b = (
                        min(r * k + np.float32(0.1), one),
                        min(g * k + np.float32(0.1), one),
                        min(b * k + np.float32(0.1), one),
                    )
            return r, g, b
        k = one + (half if s + half * t > np.float32(0.9) else np.float32(0))
        return r * k, g * k, b * k
    return r, g, b


@njit(cache=True, error_model="numpy")
def albedo(
    prim,
    points,
    footprint,
    tri_material,
    tri_part,
    tri_axis,
    frames,
    extents,
    colours,
    kinds,
    scales,
    seeds,
    emissions,
    table,
    out,
):
    """Colours of N hits into out (N, 3) float32, linear RGB; untouched where prim is negative.

    prim (N,) triangle, points (N, 3) world metres, footprint (N,) metres; triangle tables (T,), part tables frames (P, 3, 4) and
    extents (P, 3) as in SceneMesh; material tables colours (M, 3), kinds, scales (metres), seeds, emissions (M,).
    """
    for i in range(len(prim)):
        t = prim[i]
        if t < 0:
            continue
        p, m = tri_part[t], tri_material[t]
        flat = tri_axis[t]
        iu = 2 if flat == 0 else 0
        iv = 2 if flat == 1 else 1
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        u = frames[p, iu, 0] * x + frames[p, iu, 1] * y + frames[p, iu, 2] * z + frames[p, iu, 3]
        v = frames[p, iv, 0] * x + frames[p, iv, 1] * y + frames[p, iv, 2] * z + frames[p, iv, 3]
        out[i, 0], out[i, 1], out[i, 2] = _texel(
            kinds[m], u, v, extents[p, iu], extents[p, iv], scales[m], seeds[m], footprint[i],
            colours[m, 0], colours[m, 1], colours[m, 2], emissions[m], table,
        )  # fmt: skip
