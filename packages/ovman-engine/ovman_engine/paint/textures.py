"""Procedural textures, evaluated at the hits of rays.

A texture lies in the frame of its part, so it moves with the object. Its inputs are two coordinates (metres) on the hit face, the
half extents of that face, the material's colour, scale and seed, and the footprint of the pixel (metres): detail finer than the
footprint fades to its mean instead of flickering. `scale_m` is the period of the pattern.

This file imports no other kernel: numba's cache watches the file of the compiled function only.
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
    "checker",
    "stripes",
    "screen",
    "outdoors",
    "text",
    "label",
    "speckle",
)
PLAIN, WOOD, FABRIC, WEAVE, TILES, MARBLE, METAL, PRINT, PICTURE, LEAVES, PAGES, CARDBOARD = range(12)
CHECKER, STRIPES, SCREEN, OUTDOORS, TEXT, LABEL, SPECKLE = range(12, len(KINDS))
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
    """1 if a structure of this period is well resolved, 0 if pixels are as wide as it."""
    f = np.float32(1.6) - np.float32(2.0) * footprint / period
    return min(max(f, np.float32(0)), np.float32(1))


@njit(cache=True, error_model="numpy")
def _second(r, g, b, seed):
    """Return a second colour for a pattern: lighter or darker, slightly turned in hue."""
    turn = np.float32(0.25) * _hash(seed, 71, 5)
    r2, g2, b2 = r + (g - r) * turn, g + (b - g) * turn, b + (r - b) * turn
    mean = np.float32(0.33) * (r + g + b)
    if mean > np.float32(0.30) - np.float32(0.12) * _hash(seed, 72, 5):
        k = np.float32(0.30) + np.float32(0.25) * _hash(seed, 73, 5)
        return r2 * k, g2 * k, b2 * k
    k = np.float32(0.35) + np.float32(0.25) * _hash(seed, 73, 5)
    return r2 + (np.float32(0.85) - r2) * k, g2 + (np.float32(0.82) - g2) * k, b2 + (np.float32(0.76) - b2) * k


@njit(cache=True, error_model="numpy")
def _landscape(s, t, r, g, b, seed):
    """Two ridges or a shore under a sky with a sun; s to the right, t upwards, both 0 to 1."""
    one = np.float32(1)
    r2, g2, b2 = _second(r, g, b, seed)
    line = np.float32(0.25) + np.float32(0.25) * _hash(seed, 12, 0)
    wave = np.float32(6.3) * (s * (one + np.float32(2) * _hash(seed, 13, 0)) + _hash(seed, 14, 0))
    near = line + np.float32(0.06) * np.sin(wave)
    far = line + np.float32(0.14) + np.float32(0.12) * abs(np.sin(wave * np.float32(0.7) + np.float32(2)))
    if t < near:
        k = np.float32(0.55) + np.float32(0.45) * t / near
        return r2 * k, g2 * k, b2 * k
    if t < far:
        k = np.float32(0.5)
        return (r + r2) * k * k, (g + g2) * k * k + np.float32(0.02), (b + b2) * k * k + np.float32(0.04)
    cx, cy = np.float32(0.2) + np.float32(0.6) * _hash(seed, 15, 0), np.float32(0.8)
    if (s - cx) * (s - cx) + (t - cy) * (t - cy) < np.float32(0.008):
        return np.float32(0.9), np.float32(0.6), np.float32(0.3)
    k = (t - far) / (one - far)
    warm = _hash(seed, 16, 0)
    return (
        np.float32(0.75) - np.float32(0.45) * k * (one - warm * np.float32(0.6)),
        np.float32(0.68) - np.float32(0.25) * k,
        np.float32(0.6) - np.float32(0.05) * k + np.float32(0.1) * (one - warm),
    )


@njit(cache=True, error_model="numpy")
def _portrait(s, t, r, g, b, seed):
    """Head and shoulders before a plain ground."""
    r2, g2, b2 = _second(r, g, b, seed)
    x = (s - np.float32(0.5)) * np.float32(2)
    lean = np.float32(0.1) * (_hash(seed, 17, 0) - np.float32(0.5))
    tone = np.float32(0.35) + np.float32(0.65) * _hash(seed, 18, 0)
    hair = np.float32(0.02) + np.float32(0.22) * _hash(seed, 19, 0) * _hash(seed, 19, 1)
    dx, dy = (x - lean) / np.float32(0.34), (t - np.float32(0.6)) / np.float32(0.21)
    face = dx * dx + dy * dy
    if face < np.float32(1):
        eyes = abs(abs(x - lean) - np.float32(0.13)) < np.float32(0.045) and abs(t - np.float32(0.63)) < np.float32(0.018)
        mouth = abs(x - lean) < np.float32(0.1) and abs(t - np.float32(0.49)) < np.float32(0.01)
        if dy > np.float32(0.45) - np.float32(0.3) * abs(dx):
            return hair, hair * np.float32(0.6), hair * np.float32(0.35)
        if eyes or mouth:
            return np.float32(0.1), np.float32(0.04), np.float32(0.03)
        return np.float32(0.72) * tone, np.float32(0.45) * tone, np.float32(0.32) * tone
    wide = np.float32(0.42) + np.float32(0.1) * _hash(seed, 19, 2)
    dx, dy = (x - lean) / wide, (t - np.float32(0.58)) / np.float32(0.3)
    if dx * dx + dy * dy < np.float32(1):
        return hair, hair * np.float32(0.6), hair * np.float32(0.35)
    dx, dy = x / np.float32(0.85), (t - np.float32(0.02)) / np.float32(0.38)
    if dx * dx + dy * dy < np.float32(1) or (abs(x - lean) < np.float32(0.13) and t < np.float32(0.5)):
        return r, g, b
    return r2, g2, b2


@njit(cache=True, error_model="numpy")
def _still_life(s, t, r, g, b, seed):
    """Return a vase of flowers on a table."""
    r2, g2, b2 = _second(r, g, b, seed)
    for i in range(7):
        x = np.float32(0.5) + np.float32(0.5) * (_hash(seed, 40 + i, 1) - np.float32(0.5))
        y = np.float32(0.62) + np.float32(0.24) * _hash(seed, 40 + i, 2)
        size = np.float32(0.05) + np.float32(0.05) * _hash(seed, 40 + i, 3)
        far = (s - x) * (s - x) + (t - y) * (t - y)
        if far < np.float32(0.1) * size * size:
            return np.float32(0.8), np.float32(0.6), np.float32(0.1)
        if far < size * size:
            if i & 1:
                return np.float32(0.75), np.float32(0.18), np.float32(0.2)
            return np.float32(0.85), np.float32(0.75), np.float32(0.7)
    x = abs(s - np.float32(0.5))
    if t > np.float32(0.42) and t < np.float32(0.66) and x < np.float32(0.3) * (t - np.float32(0.3)):
        return np.float32(0.06), np.float32(0.2), np.float32(0.07)
    if t > np.float32(0.14) and t < np.float32(0.46):
        belly = np.float32(0.15) - np.float32(1.6) * (t - np.float32(0.28)) * (t - np.float32(0.28))
        if x < belly:
            return r, g, b
    if t < np.float32(0.24):
        return r2 * np.float32(0.5), g2 * np.float32(0.5), b2 * np.float32(0.5)
    return r2, g2, b2


@njit(cache=True, error_model="numpy")
def _picture(s, t, r, g, b, seed):
    """Return a framed picture on the unit square: a landscape, a portrait, flowers or shapes; t upwards."""
    one = np.float32(1)
    style = _hash(seed, 11, 0)
    if style < 0.4:
        return _landscape(s, t, r, g, b, seed)
    if style < 0.55:
        return _portrait(s, t, r, g, b, seed)
    if style < 0.7:
        return _still_life(s, t, r, g, b, seed)
    r2, g2, b2 = _second(r, g, b, seed)
    out_r, out_g, out_b = np.float32(0.72), np.float32(0.68), np.float32(0.6)
    for i in range(6):
        x, y = _hash(seed, 20 + i, 1), _hash(seed, 20 + i, 2)
        w, h = (
            np.float32(0.08) + np.float32(0.28) * _hash(seed, 20 + i, 3),
            np.float32(0.08) + np.float32(0.28) * _hash(seed, 20 + i, 4),
        )
        k = np.float32(0.35) + np.float32(0.9) * _hash(seed, 20 + i, 5)
        inside = abs(s - x) < w and abs(t - y) < h
        if style > 0.86:
            inside = (s - x) * (s - x) + (t - y) * (t - y) < w * w
        if inside:
            if i & 1:
                out_r, out_g, out_b = r * k, g * k, b * k
            else:
                out_r, out_g, out_b = r2 * k, g2 * k, b2 * k
    return min(out_r, one), min(out_g, one), min(out_b, one)


@njit(cache=True, error_model="numpy")
def _outdoors(s, t, u, v, r, g, b, seed, table):
    """Return the view through a window: clouds, far hills, trees, a lawn; s, t 0 to 1, t upwards; u, v metres."""
    one = np.float32(1)
    shift = np.float32(100) * _hash(seed, 50, 0)
    line = np.float32(0.24) + np.float32(0.16) * _hash(seed, 51, 0)
    bumps = _look(table, CLOUDS, u * np.float32(90) + shift, shift)
    trees = line + np.float32(0.1) + np.float32(0.12) * bumps
    hills = line + np.float32(0.14) + np.float32(0.06) * np.sin(u * np.float32(2.5) + shift)
    if t < line - np.float32(0.08):
        k = np.float32(0.8) + np.float32(0.12) * _look(table, CLOUDS, u * np.float32(60), v * np.float32(240) + shift)
        return np.float32(0.20) * k, np.float32(0.27) * k, np.float32(0.11) * k
    if t < trees:
        k = np.float32(0.75) + np.float32(0.45) * _look(table, CLOUDS, u * np.float32(420) + shift, v * np.float32(420))
        k *= np.float32(0.55) + np.float32(0.7) * (t - line + np.float32(0.1))
        return np.float32(0.13) * k, np.float32(0.20) * k, np.float32(0.08) * k
    if t < hills:
        return np.float32(0.30), np.float32(0.42), np.float32(0.42)
    haze = one - (t - hills) / (one - hills)
    haze = np.float32(0.7) * haze * haze
    cloud = _look(table, CLOUDS, u * np.float32(22) + shift, v * np.float32(50) + shift) * np.float32(1.4)
    haze = min(max(haze + max(cloud, np.float32(0)), np.float32(0)), np.float32(0.95))
    return r + (np.float32(0.95) - r) * haze, g + (np.float32(0.96) - g) * haze, b + (np.float32(0.98) - b) * haze


@njit(cache=True, error_model="numpy")
def _ink(u, v, line, footprint, seed):
    """Ink, 0 to 1, at a point of lines of words. `line`: distance between lines, metres."""
    row = np.floor(v / line)
    y = v / line - row
    word = np.float32(3.2) * line
    x = u / word + np.float32(7) * _hash(np.int64(row), seed, 61)
    k = np.floor(x)
    gap = np.float32(0.12) + np.float32(0.3) * _hash(np.int64(row), np.int64(k), seed)
    fine = np.float32(0.72) * _fade(footprint, line) if (y > 0.3 and y < 0.8 and x - k > gap) else np.float32(0)
    return fine + np.float32(0.28) * (np.float32(1) - _fade(footprint, line))


@njit(cache=True, error_model="numpy")
def _text(u, v, hu, hv, r, g, b, scale, footprint, seed):
    """Return a printed page: a headline, columns of words, a picture among them."""
    if hu < np.float32(0.03) or hv < np.float32(0.03):
        return r, g, b
    s, t = u / (hu + hu) + np.float32(0.5), v / (hv + hv) + np.float32(0.5)
    if s < 0.05 or s > 0.95 or t < 0.04 or t > 0.96:
        return r, g, b
    ink = np.float32(0)
    if t < 0.2:
        ink = _ink(u, v, np.float32(0.14) * hv, footprint, seed)
    else:
        columns = max(np.floor(hu / np.float32(0.045)), np.float32(2))
        place = s * columns - np.floor(s * columns)
        if _hash(np.int64(np.floor(s * columns)), seed, 62) > 0.6 and t > 0.3 and t < 0.55:
            k = np.float32(0.2) + np.float32(0.5) * abs(t - np.float32(0.42)) * np.float32(4)
            return r * k, g * k, b * k
        if place > 0.06 and place < 0.94:
            ink = _ink(u, v, scale, footprint, seed)
    k = np.float32(1) - np.float32(0.85) * ink
    return r * k, g * k, b * k


@njit(cache=True, error_model="numpy")
def _label(s, t, u, v, hv, r, g, b, footprint, seed):
    """Return a product's print: a coloured band, an emblem, lines of words."""
    r2, g2, b2 = _second(r, g, b, seed)
    hue = _hash(seed, 70, 0)
    r3, g3, b3 = np.float32(0.6) * hue, np.float32(0.5) * _hash(seed, 70, 1), np.float32(0.6) * (np.float32(1) - hue)
    if t > 0.72 and t < 0.93:
        if abs(s - np.float32(0.5)) < 0.34 and abs(t - np.float32(0.82)) < 0.06:
            k = _ink(u, v, np.float32(0.24) * hv, footprint, seed)
            return r3 + (np.float32(0.85) - r3) * k, g3 + (np.float32(0.85) - g3) * k, b3 + (np.float32(0.8) - b3) * k
        return r3, g3, b3
    x, y = s - np.float32(0.5), (t - np.float32(0.5)) * np.float32(1.3)
    round_one = _hash(seed, 71, 0) < 0.5
    if (round_one and x * x + y * y < np.float32(0.03)) or (not round_one and abs(x) + abs(y) < np.float32(0.22)):
        return r2, g2, b2
    if t > 0.08 and t < 0.28 and abs(x) < 0.38:
        k = np.float32(1) - np.float32(0.8) * _ink(u, v, np.float32(0.11) * hv, footprint, seed)
        return r * k, g * k, b * k
    return r, g, b


@njit(cache=True, error_model="numpy")
def _screen(s, t, u, v, hv, r, g, b, footprint, seed):
    """Return a lit screen: a film, or windows with text on a desktop."""
    if _hash(seed, 80, 0) < 0.45:
        return _landscape(s, t, r, g, b, seed)
    k = np.float32(0.5) + np.float32(0.5) * t
    r, g, b = r * k, g * k, b * k
    if t < 0.06:
        k = np.float32(0.12) if np.int64(np.floor(s * np.float32(16))) % 3 else np.float32(0.5)
        return k * np.float32(0.8), k * np.float32(0.9), k
    for i in range(2):
        x0, y0 = np.float32(0.06) + np.float32(0.34) * i, np.float32(0.12) + np.float32(0.12) * _hash(seed, 81 + i, 1)
        wide, high = np.float32(0.34) + np.float32(0.2) * _hash(seed, 81 + i, 2), np.float32(0.6)
        if s > x0 and s < x0 + wide and t > y0 and t < y0 + high:
            if t > y0 + high - np.float32(0.07):
                return np.float32(0.12), np.float32(0.2), np.float32(0.42)
            if s < x0 + np.float32(0.03) or s > x0 + wide - np.float32(0.03) or t < y0 + np.float32(0.04):
                return np.float32(0.85), np.float32(0.86), np.float32(0.87)
            k = np.float32(0.86) * (np.float32(1) - np.float32(0.8) * _ink(u, v, np.float32(0.1) * hv, footprint, seed + i))
            return k, k, k
    return r, g, b


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
        k, clear = np.float32(0), _fade(footprint, np.float32(0.030))
        if clear > 0:
            k = _look(table, GRAIN, (u + ou) * np.float32(60), (v + ov) * np.float32(520)) * clear * np.float32(0.20)
        k += _look(table, CLOUDS, (u + ou) * np.float32(30), (v + ov) * np.float32(170)) * np.float32(0.12)
        k = tone * (one + k)
        return r * k, g * k * (one - np.float32(0.03) * (one - k)), b * k
    if kind == FABRIC:
        k, clear = np.float32(0), _fade(footprint, np.float32(0.016))
        if clear > 0:
            k = np.float32(0.10) * _look(table, THREAD, (u + ou) * np.float32(400), (v + ov) * np.float32(400)) * clear
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
        k, clear = one, _fade(footprint, np.float32(0.01))
        if clear > 0:
            k += np.float32(0.05) * _look(table, GRAIN, (u + ou) * np.float32(12), (v + ov) * np.float32(1400)) * clear
        k += np.float32(0.03) * _look(table, CLOUDS, (u + ou) * np.float32(40), (v + ov) * np.float32(40))
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
            return _screen(s, t, u, v, hv, r, g, b, footprint, seed)
        k = one + (half if s + half * t > np.float32(0.9) else np.float32(0))
        return r * k, g * k, b * k
    if kind == OUTDOORS:
        return _outdoors(u / (hu + hu) + half, v / (hv + hv) + half, u, v, r, g, b, seed, table)
    if kind == TEXT:
        return _text(u, v, hu, hv, r, g, b, scale, footprint, seed)
    if kind == LABEL:
        return _label(u / (hu + hu) + half, v / (hv + hv) + half, u, v, hv, r, g, b, footprint, seed)
    if kind == SPECKLE:
        k, clear = one, _fade(footprint, scale)
        if clear > 0:
            grain = np.float32(6.4) / scale
            k += (
                np.float32(0.2) * _look(table, THREAD, u * grain + np.float32(100) * ou, v * grain + np.float32(100) * ov) * clear
            )
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
    """Write the colours of N hits to out (N, 3) float32, linear RGB; rows without a hit (prim negative) stay as they are.

    prim (N,) triangle, points (N, 3) world metres, footprint (N,) metres; triangle tables (T,), part tables frames (P, 3, 4) and
    extents (P, 3) as in TriangleMesh; material tables colours (M, 3), kinds, scales (metres), seeds, emissions (M,).
    """
    for i in range(len(prim)):
        t = prim[i]
        if t < 0:
            continue
        p, m = tri_part[t], tri_material[t]
        if kinds[m] == PLAIN:
            out[i, 0], out[i, 1], out[i, 2] = colours[m, 0], colours[m, 1], colours[m, 2]
            continue
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
