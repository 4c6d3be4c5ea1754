"""Vectors in AI2-THOR's metadata."""

from __future__ import annotations


def vector(x: float, y: float, z: float) -> dict[str, float]:
    """Return a vector as AI2-THOR writes it: {"x": ..., "y": ..., "z": ...}."""
    return {"x": float(x), "y": float(y), "z": float(z)}
