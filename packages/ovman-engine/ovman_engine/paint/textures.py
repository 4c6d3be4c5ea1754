"""The kinds of procedural textures, and the noise that they are made of; kernels/textures.cpp evaluates them.

A texture lies in the frame of its part, so it moves with the object.
"""

from __future__ import annotations

from functools import cache

import numpy as np

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
TILE = 256
"""Width of the noise tables; a power of two."""


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
