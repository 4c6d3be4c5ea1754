"""The visible body of the agent: a base, a trunk, and a head around the camera with an arrow for its direction.

Parts are in the agent's frame: origin at its position, y up, z ahead, metres. The body takes no part in collisions, which use the
capsule of the embodiment.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ovman_engine.bodies.body import Agent
from ovman_engine.bodies.embodiment import Embodiment
from ovman_engine.paint.materials import Material, linear
from ovman_engine.shapes.part import Part, column, span

PALETTE = MappingProxyType(
    {
        "shell": Material(linear(0.58, 0.06, 0.82), gloss=0.35),
        "dark": Material(linear(0.6, 0.1, 0.14), gloss=0.4),
        "mark": Material(linear(0.56, 0.85, 0.5), gloss=0.2),
    }
)


@dataclass(frozen=True)
class _Build:
    """Radii of the parts above the base, metres."""

    trunk: float
    head: float


BUILDS = {"default": _Build(0.145, 0.12), "locobot": _Build(0.04, 0.075)}
BASE_M = 0.16
"""Height of the base"""
NECK_M = 0.03
ABOVE_EYE_M = 0.15
"""Height of the head above the camera, with some margin"""
MARK_M = 0.012
"""Height of the arrow on the head, which is visible from above"""


def encloses(agent: Agent, point: np.ndarray) -> bool:
    """Whether a point (3,) of the world is within the upright cylinder around the agent's body."""
    away = point - agent.position
    top = agent.embodiment.camera_m(agent.standing) + ABOVE_EYE_M
    return bool(np.hypot(away[0], away[2]) < agent.embodiment.radius_m and agent.embodiment.foot_m < away[1] < top)


def parts(embodiment: Embodiment, standing: bool) -> tuple[Part, ...]:
    """Return the parts of the body. The head follows the camera when the agent crouches."""
    build = BUILDS.get(embodiment.mode, BUILDS["default"])
    foot, eye, r = embodiment.foot_m, embodiment.camera_m(standing), build.head
    base = 0.95 * embodiment.radius_m
    neck = eye - r - NECK_M
    return (
        column(0.0, 0.0, foot + 0.02, foot + BASE_M, base, "dark"),
        column(0.0, 0.0, foot + BASE_M - 0.02, neck, build.trunk, "shell", kind="capsule"),
        column(0.0, 0.0, neck - 0.03, eye, 0.4 * build.trunk, "dark"),
        Part("cushion", (0.0, eye, 0.0), (2 * r, 1.7 * r, 1.9 * r), slot="shell", ratio=0.4),
        span((-0.75 * r, eye - 0.3 * r, 0.7 * r), (0.75 * r, eye + 0.4 * r, 1.02 * r), "dark"),
        span((-0.12 * r, eye + 0.8 * r, -0.6 * r), (0.12 * r, eye + 0.85 * r + MARK_M, 1.05 * r), "mark"),
        span((-0.5 * r, eye + 0.8 * r, 0.75 * r), (0.5 * r, eye + 0.85 * r + MARK_M, 1.05 * r), "mark"),
    )
