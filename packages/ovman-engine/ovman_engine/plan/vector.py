"""Vectors as AI2-THOR writes them."""

from __future__ import annotations


def vector(x: float, y: float, z: float) -> dict[str, float]:
    return {"x": float(x), "y": float(y), "z": float(z)}
