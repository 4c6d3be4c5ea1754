"""Convex collision pieces of parts.

A piece is a tuple in the frame of the oriented box, metres; the axis of cylinders and capsules is y of their rotation:

    ("box", centre, half, rotation)
    ("cylinder", centre, radius, half_height, rotation)
    ("capsule", centre, radius, half_height, rotation)      half_height of the straight middle
    ("sphere", centre, radius)
    ("ellipsoid", centre, half, rotation)
    ("hull", vertices (V, 3))
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ovman_engine.shapes.part import Part
from ovman_engine.shapes.tessellation import mesh, revolved

Piece = tuple[Any, ...]

_ROUND_M = 1e-6
_WALL_PIECES = 6


def _hull(part: Part, vertices: np.ndarray) -> Piece:
    return ("hull", vertices @ part.rotation.T + part.centre)


def _hollow(profile: np.ndarray) -> bool:
    """Whether a lathe profile turns back down inside (a bowl) or never meets the axis (a ring)."""
    return bool(profile[:, 0].min() > _ROUND_M or profile[-1, 1] < profile[:, 1].max() - 0.25 * np.ptp(profile[:, 1]))


def _shell(part: Part) -> list[Piece]:
    """Segments of the wall, and the bottom if the profile has one."""
    profile = part.outline
    scale = part.size / [2 * profile[:, 0].max(), 1.0, 2 * profile[:, 0].max()]
    scale[1] = 1.0
    ring = profile[:, 0].min() > _ROUND_M
    rim = int(profile[:, 1].argmax())
    outside, inside = profile[: rim + 1], profile[rim:]
    floor = float(profile[0, 1]) if ring else float(profile[-1, 1])
    thinnest = np.interp(np.unique(profile[:, 1]), inside[::-1, 1], inside[::-1, 0]) if not ring else profile[:, 0]
    inner_low, inner_top = float(np.min(thinnest[thinnest > _ROUND_M], initial=0.5 * profile[:, 0].max())), float(inside[0, 0])
    foot = outside[outside[:, 0] > _ROUND_M][0]
    levels = [(float(foot[0]), float(profile[:, 1].min())), (float(outside[-1, 0]), float(profile[:, 1].max()))]
    inner_low = min(inner_low, 0.9 * levels[0][0])
    pieces = []
    edges = np.linspace(0, 2 * np.pi, _WALL_PIECES + 1)
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        corners = []
        for angle in (first, last):
            direction = np.array([np.cos(angle), 0.0, np.sin(angle)])
            corners += [direction * levels[0][0] + [0, levels[0][1], 0], direction * inner_low + [0, levels[0][1], 0]]
            corners += [
                direction * levels[1][0] + [0, levels[1][1], 0],
                direction * min(inner_top, 0.92 * levels[1][0]) + [0, levels[1][1], 0],
            ]
        pieces.append(_hull(part, np.array(corners) * scale))
    if not ring and floor > profile[:, 1].min() + _ROUND_M:
        disc = np.array([(0.0, profile[:, 1].min()), (levels[0][0], profile[:, 1].min()), (levels[0][0], floor), (0.0, floor)])
        pieces.append(_hull(part, revolved(disc, 8)[0] * scale))
    return pieces


def collision(part: Part) -> list[Piece]:
    """Convex pieces of `part` in the frame of the oriented box; none if not solid. A hollow lathe gives walls and bottom."""
    if not part.solid:
        return []
    half = part.size / 2
    round_about_y = abs(half[0] - half[2]) < _ROUND_M
    if part.kind == "box":
        return [("box", part.centre, half, part.rotation)]
    if part.kind == "cylinder" and round_about_y:
        return [("cylinder", part.centre, float(half[0]), float(half[1]), part.rotation)]
    if part.kind == "capsule" and round_about_y and half[1] > half[0] + _ROUND_M:
        return [("capsule", part.centre, float(half[0]), float(half[1] - half[0]), part.rotation)]
    if part.kind == "ellipsoid":
        if np.ptp(half) < _ROUND_M:
            return [("sphere", part.centre, float(half[0]))]
        return [("ellipsoid", part.centre, half, part.rotation)]
    if part.kind == "torus":
        tube = part.ratio * half[0] / 2
        ring = np.array([(half[0] - 2 * tube, -half[1]), (half[0], -half[1]), (half[0], half[1]), (half[0] - 2 * tube, half[1])])
        return _shell(part.but(kind="lathe", points=np.concatenate([ring, ring[:1]])))
    if part.kind == "tube":
        ends = part.outline @ part.rotation.T + part.centre
        return [
            ("hull", np.concatenate([_disc(a, b - a, part.ratio), _disc(b, b - a, part.ratio)]))
            for a, b in zip(ends[:-1], ends[1:], strict=True)
        ]
    if part.kind == "lathe" and _hollow(part.outline):
        return _shell(part)
    coarse = part.but(segments=8) if part.kind in ("cylinder", "frustum", "cushion", "lathe", "capsule") else part
    return [("hull", mesh(coarse)[0])]


def _disc(centre: np.ndarray, axis: np.ndarray, radius: float) -> np.ndarray:
    side = np.cross(axis, [0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 * np.linalg.norm(axis) else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    other = np.cross(axis / np.linalg.norm(axis), side)
    return np.array([centre + radius * (c * side + s * other) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))])
